# Targets that run a test's program, or those of its rows that match a pattern, for long and keep what it counts for the papers:
# stability-NAME writes papers/data/stability/NAME.json. The emulated twin stands in on a machine without AVX-512, as it has all kernels.
# The extremes take seconds, the exhaustive test of all fields forty minutes, the stress test half an hour.
function(cellwalk_count name rounds program)
    set(data papers/data/stability) # run in the project's folder, so that no path is recorded
    set(tests test_${program}_avx512_emulated test_${program})
    if(EXISTS /proc/cpuinfo)
        file(STRINGS /proc/cpuinfo avx512 REGEX "avx512dq" LIMIT_COUNT 1)
        if(avx512)
            list(REVERSE tests)
        endif()
    endif()
    foreach(test IN LISTS tests)
        if(TARGET ${test})
            add_custom_target(stability-${name} COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
                COMMAND ${CMAKE_COMMAND} -E env CELLWALK_TEST_COUNTS=${data}/${name}.json CELLWALK_TEST_ROUNDS=${rounds}
                    $<TARGET_FILE:${test}> ${ARGN}
                COMMAND ${CMAKE_COMMAND} -DFILE=${data}/${name}.json -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/stamp.cmake
                WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
            add_dependencies(stability-${name} ${test})
            return()
        endif()
    endforeach()
endfunction()
