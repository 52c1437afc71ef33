# Adds commit and date to the first line of a file of counts. Run in the project's folder. Argument: FILE.
execute_process(COMMAND git rev-parse --short=10 HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(commit STREQUAL "")
    message(FATAL_ERROR "${FILE}: there is no commit to name; this needs git and the project's repository")
endif()
# The data themselves, which have just changed, do not count.
execute_process(COMMAND git status --porcelain --untracked-files=no -- . ":!papers/data" OUTPUT_VARIABLE changes)
if(NOT changes STREQUAL "")
    string(APPEND commit " with changes")
endif()
string(TIMESTAMP date "%Y-%m-%dT%H:%M:%SZ" UTC)
file(READ ${FILE} text)
string(FIND "${text}" "}" end) # of the first object, which holds no other
string(SUBSTRING "${text}" 0 ${end} run)
string(SUBSTRING "${text}" ${end} -1 rest)
file(WRITE ${FILE} "${run}, \"commit\": \"${commit}\", \"date\": \"${date}\"${rest}")
