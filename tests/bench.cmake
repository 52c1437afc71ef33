# Tests of the benchmark: its workloads, its arithmetic, its commands.
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    cellwalk_test(bench_guard bench_guard.c)
    target_link_libraries(test_bench_guard PRIVATE cellwalk_guard_figures cellwalk_test_scratch)
    cellwalk_test(bench_workload bench_workload.c)
    target_link_libraries(test_bench_workload PRIVATE cellwalk_workload)
    if(TARGET cellwalk_measure)
        foreach(name IN ITEMS bench_statistics bench_agree bench_program)
            cellwalk_test(${name} ${name}.c)
            target_link_libraries(test_${name} PRIVATE cellwalk_measure)
        endforeach()
        target_link_libraries(test_bench_program PRIVATE cellwalk_test_scratch)
        add_dependencies(test_bench_program scenes)
    endif()
endif()
# The guard against slow-downs; the test tells why where it is skipped.
add_test(NAME guard WORKING_DIRECTORY ${PROJECT_BINARY_DIR}/bench
    COMMAND cellwalk_guard check $<TARGET_FILE:cellwalk_guard_work> ${PROJECT_SOURCE_DIR}/bench/guard.csv)
set_tests_properties(guard PROPERTIES LABELS guard SKIP_RETURN_CODE 77 TIMEOUT 300)
