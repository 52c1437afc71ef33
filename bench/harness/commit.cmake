# Run at build time: writes the commit that is being built, and only if it has changed, so that nothing is compiled anew
# for nothing. Without git, or outside a repository, it is "unknown".
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=10 HEAD OUTPUT_VARIABLE commit ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
if(failed)
    set(commit unknown)
else()
    execute_process(COMMAND git -C ${SOURCE} status --porcelain --untracked-files=no OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
        string(APPEND commit " with changes")
    endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define BUILD_INFO_COMMIT \"@commit@\"\n" @ONLY)
