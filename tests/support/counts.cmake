# Targets that run a test's program, or those of its rows that match a pattern, for long and keep what it counts for the papers:
# stability-NAME writes the lines of JSON that it prints to papers/data/stability/NAME.json. The emulated twin stands in on a machine
# without AVX-512, as it has all kernels. The extremes take seconds, the exhaustive test of all fields forty minutes, the stress test half
# an hour.
if(CMAKE_SCRIPT_MODE_FILE) # run in the project's folder, so that no path is recorded. Arguments: RUN, ROUNDS, COMMAND, FILE
    execute_process(COMMAND git rev-parse --short=10 HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(commit STREQUAL "")
        message(FATAL_ERROR "${FILE}: there is no commit to name; this needs git and the project's repository")
    endif()
    execute_process(COMMAND git status --porcelain --untracked-files=no -- . ":!papers/data" OUTPUT_VARIABLE changes)
    if(NOT changes STREQUAL "")
        string(APPEND commit " with changes")
    endif()
    execute_process(COMMAND ${CMAKE_COMMAND} -E env CELLWALK_TEST_ROUNDS=${ROUNDS} ${RUN} OUTPUT_VARIABLE text ECHO_OUTPUT_VARIABLE
        COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE "(^|\n)[^{\n][^\n]*" "" text "\n${text}")
    string(REGEX REPLACE "\n+" "\n" text "${text}")
    string(TIMESTAMP date "%Y-%m-%dT%H:%M:%SZ" UTC)
    file(WRITE ${FILE} "{\"kind\": \"run\", \"command\": \"${COMMAND}\", \"commit\": \"${commit}\", \"date\": \"${date}\"}${text}")
    return()
endif()

function(cellwalk_count name rounds program)
    set(tests test_${program}_emulated test_${program})
    if(EXISTS /proc/cpuinfo)
        file(STRINGS /proc/cpuinfo avx512 REGEX "avx512dq" LIMIT_COUNT 1)
        if(avx512)
            list(REVERSE tests)
        endif()
    endif()
    foreach(test IN LISTS tests)
        if(TARGET ${test})
            add_custom_target(stability-${name} COMMAND ${CMAKE_COMMAND} "-DRUN=$<TARGET_FILE:${test}>;${ARGN}" -DROUNDS=${rounds}
                -DCOMMAND=stability-${name} -DFILE=papers/data/stability/${name}.json -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
                WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
            add_dependencies(stability-${name} ${test})
            return()
        endif()
    endforeach()
endfunction()
