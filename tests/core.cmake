# Tests of the tracing core.
find_package(Threads REQUIRED)
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    add_library(cellwalk_test_rays STATIC fields.c rays.c)
    target_include_directories(cellwalk_test_rays PRIVATE ${CMOCKA_INCLUDE})
    target_link_libraries(cellwalk_test_rays PUBLIC cellwalk::cellwalk_static PRIVATE cellwalk_flags ${CMOCKA_LIBRARY})

    cellwalk_test(api api.c)
    target_link_libraries(test_api PRIVATE cellwalk_test_rays)
    cellwalk_test(environment environment.c)
    target_link_libraries(test_environment PRIVATE cellwalk_test_rays Threads::Threads)
    cellwalk_test(lanes lanes.c)
    target_link_libraries(test_lanes PRIVATE cellwalk_test_rays)
endif()

if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY AND GMP_INCLUDE AND GMP_LIBRARY)
    add_library(cellwalk_test_oracle STATIC exact.c judge.c oracle.c tally.c)
    target_include_directories(cellwalk_test_oracle PUBLIC ${GMP_INCLUDE})
    target_link_libraries(cellwalk_test_oracle PRIVATE cellwalk_flags PUBLIC cellwalk_test_rays ${GMP_LIBRARY} m)

    cellwalk_test(oracle oracle_test.c)
    target_link_libraries(test_oracle PRIVATE cellwalk_test_oracle)
    foreach(test IN ITEMS brute exhaustive extremes watertight)
        cellwalk_test(${test} ${test}.c)
        target_link_libraries(test_${test} PRIVATE cellwalk_test_oracle)
    endforeach()
endif()

# The installed library, and what leaves it. Sanitizers add symbols and need their flags in the consumer too.
if(NOT CELLWALK_SANITIZE)
    add_test(NAME install COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR}
        -DWORK=${CMAKE_CURRENT_BINARY_DIR}/install -DCONSUMER=${CMAKE_CURRENT_SOURCE_DIR}/consumer
        -DCC=${CMAKE_C_COMPILER} -DCONFIG=${CMAKE_BUILD_TYPE} -DGENERATOR=${CMAKE_GENERATOR}
        -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/install.cmake)
    add_test(NAME symbols COMMAND ${CMAKE_COMMAND} "-DSHARED=$<$<TARGET_EXISTS:cellwalk>:$<TARGET_FILE:cellwalk::cellwalk>>"
        -DSTATIC=$<TARGET_FILE:cellwalk::cellwalk_static> -DNM=${CMAKE_NM} -DOBJDUMP=${CMAKE_OBJDUMP} -DSIMD=${CELLWALK_SIMD}
        -P ${CMAKE_CURRENT_SOURCE_DIR}/symbols.cmake)
    set_tests_properties(symbols PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED")
endif()
