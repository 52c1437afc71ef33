# Tests of picture files.
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    cellwalk_test(image_formats image_formats.c)
    target_link_libraries(test_image_formats PRIVATE cellwalk_test_scratch cellwalk_io)
endif()
