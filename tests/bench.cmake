# Tests of the benchmark: its workloads, its arithmetic, its commands.
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    cellwalk_test(bench_guard bench_guard.c)
    target_link_libraries(test_bench_guard PRIVATE cellwalk_guard_figures cellwalk_test_scratch)
    cellwalk_test(bench_workload bench_workload.c)
    target_link_libraries(test_bench_workload PRIVATE cellwalk_workload)
    if(TARGET cellwalk_measure)
        foreach(name IN ITEMS bench_statistics bench_agree bench_tradeoff bench_tradeoff_program bench_program)
            cellwalk_test(${name} ${name}.c)
            target_link_libraries(test_${name} PRIVATE cellwalk_measure)
        endforeach()
        target_link_libraries(test_bench_program PRIVATE cellwalk_test_scratch)
        target_link_libraries(test_bench_tradeoff_program PRIVATE cellwalk_test_scratch)
        add_dependencies(test_bench_tradeoff_program scenes)
        cellwalk_test(bench_counters bench_counters.c ${CELLWALK_COUNTING_OBJECTS})
        target_link_libraries(test_bench_counters PRIVATE cellwalk_measure)
        add_dependencies(test_bench_program scenes)
    endif()
endif()
if(TARGET cellwalk_bench)
    add_test(NAME bench_measure COMMAND ${CMAKE_COMMAND} -DBENCH=$<TARGET_FILE:cellwalk_bench>
        -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}/bench_measure -P ${CMAKE_CURRENT_SOURCE_DIR}/bench_measure.cmake)
    set_tests_properties(bench_measure PROPERTIES TIMEOUT 300)
endif()
if(TARGET cellwalk_instructions AND NOT CELLWALK_SANITIZE) # valgrind does not run sanitized programs
    add_test(NAME bench_caches COMMAND ${CMAKE_COMMAND} -DCACHES=$<TARGET_FILE:cellwalk_instructions>
        -DWORK=$<TARGET_FILE:cellwalk_counted_work> -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}/bench_caches
        -P ${CMAKE_CURRENT_SOURCE_DIR}/bench_caches.cmake)
    set_tests_properties(bench_caches PROPERTIES TIMEOUT 300 SKIP_REGULAR_EXPRESSION "SKIPPED")
endif()
add_test(NAME papers_notes COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/papers_notes.cmake)
# The levers that papers/report.md takes away one by one are still where bench/instructions/ablation.cmake looks for them.
add_test(NAME ablation_levers COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR}
    -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}/ablation_levers -P ${PROJECT_SOURCE_DIR}/bench/instructions/ablation.cmake)
# The guard against slow-downs; the test tells why where it is skipped.
add_test(NAME guard WORKING_DIRECTORY ${PROJECT_BINARY_DIR}/bench
    COMMAND cellwalk_guard check $<TARGET_FILE:cellwalk_counted_work> ${PROJECT_SOURCE_DIR}/bench/instructions/guard.csv)
set_tests_properties(guard PROPERTIES LABELS guard SKIP_RETURN_CODE 77 TIMEOUT 300)
