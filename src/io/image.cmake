# Pictures. OpenEXR (its C library) and libpng are optional; each sits behind one file.
target_sources(cellwalk_io PRIVATE image.c)

find_package(OpenEXR 3.1 CONFIG QUIET GLOBAL)
if(TARGET OpenEXR::OpenEXRCore)
    target_sources(cellwalk_io PRIVATE image_exr.c)
    target_link_libraries(cellwalk_io PRIVATE OpenEXR::OpenEXRCore)
    target_compile_definitions(cellwalk_io PRIVATE CELLWALK_OPENEXR)
endif()

find_package(PNG QUIET GLOBAL)
if(TARGET PNG::PNG)
    target_sources(cellwalk_io PRIVATE image_png.c)
    target_link_libraries(cellwalk_io PRIVATE PNG::PNG)
    target_compile_definitions(cellwalk_io PRIVATE CELLWALK_PNG)
endif()
