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
