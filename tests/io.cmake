# Tests of files: arrays, rasters, output.
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    add_library(cellwalk_test_scratch STATIC scratch.c)
    target_include_directories(cellwalk_test_scratch PRIVATE ${CMOCKA_INCLUDE})
    target_link_libraries(cellwalk_test_scratch PRIVATE cellwalk::cellwalk_static cellwalk_flags PUBLIC ${CMOCKA_LIBRARY})

    foreach(name IN ITEMS io_npy io_output io_raster)
        cellwalk_test(${name} ${name}.c)
        target_link_libraries(test_${name} PRIVATE cellwalk_test_scratch cellwalk_io)
    endforeach()
endif()
