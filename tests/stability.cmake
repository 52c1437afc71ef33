# The long run of stability.c, and the part of it that is a test. It takes fields and Embree from bench/, and stands
# here because it needs the oracle, hence GMP, which the benchmark must not.
if(NOT TARGET cellwalk_test_oracle)
    return()
endif()
set(all_extremes test_extremes)
if(TARGET test_extremes_avx512_emulated)
    set(all_extremes test_extremes_avx512_emulated)
endif()
add_library(cellwalk_stability_run STATIC EXCLUDE_FROM_ALL aimed.c stability_run.c)
target_include_directories(cellwalk_stability_run PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(cellwalk_stability_run PRIVATE cellwalk_flags
    PUBLIC cellwalk_test_oracle cellwalk_test_rays cellwalk_workload cellwalk_peers)
if(TARGET cellwalk_measure AND TARGET test_extremes) # JSON, options and pages
    add_executable(cellwalk_stability stability.c stability_page.c stability_tables.c)
    set_target_properties(cellwalk_stability PROPERTIES OUTPUT_NAME cellwalk-stability)
    target_link_libraries(cellwalk_stability PRIVATE cellwalk_stability_run cellwalk_measure cellwalk_flags)
    # Figures for papers/stability.md. The long run takes a quarter of an hour to half of one and is started by hand,
    # not by CTest; the extremes take seconds, the exhaustive test of all fields forty minutes, the stress test half an hour.
    set(data papers/data/stability) # all run in the project's folder, so that no path is recorded
    set(page papers/stability.md)
    add_custom_target(stability
        COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
        COMMAND cellwalk_stability run --json ${data}/aimed.json
        COMMAND cellwalk_stability report --json ${data}/aimed.json --into ${page}
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
    add_custom_target(stability-extremes
        COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
        COMMAND ${CMAKE_COMMAND} -E env CELLWALK_TEST_COUNTS=${data}/extremes.json $<TARGET_FILE:${all_extremes}>
        COMMAND cellwalk_stability report --json ${data}/extremes.json --into ${page}
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
    add_dependencies(stability-extremes ${all_extremes})
    add_custom_target(stability-exhaustive
        COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
        COMMAND ${CMAKE_COMMAND} -E env CELLWALK_TEST_COUNTS=${data}/exhaustive.json CELLWALK_TEST_ROUNDS=1001
            $<TARGET_FILE:test_exhaustive>
        COMMAND cellwalk_stability report --json ${data}/exhaustive.json --into ${page}
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
    add_dependencies(stability-exhaustive test_exhaustive)
    add_custom_target(stability-stress
        COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
        COMMAND ${CMAKE_COMMAND} -E env CELLWALK_TEST_COUNTS=${data}/stress.json CELLWALK_TEST_ROUNDS=170
            $<TARGET_FILE:test_stress>
        COMMAND cellwalk_stability report --json ${data}/stress.json --into ${page}
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
    add_dependencies(stability-stress test_stress)
    add_custom_target(stability-leaf
        COMMAND ${CMAKE_COMMAND} -E make_directory ${data}
        COMMAND cellwalk_bench micro --kernel cell,packet8,pyramid8x2 --leaf all --peer none --field 257,1025 --seconds 120
            --pass 2 --json ${data}/leaf.json
        COMMAND cellwalk_stability report --json ${data}/leaf.json --into papers/watertight.md
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
endif()
