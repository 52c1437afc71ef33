# Tests of what terrain people ask for.
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    cellwalk_test(heading terrain/heading.c)
    target_link_libraries(test_heading PRIVATE cellwalk_test_rays)
endif()
