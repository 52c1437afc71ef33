# cpack makes Debian packages: libcellwalk1, libcellwalk-dev, cellwalk, and python3-cellwalk where the module is built. A build tree
# for them is configured with the prefix /usr, as the preset package is, so that libraries lie where Debian has them. Files that
# Debian requires beside those that are installed come from debian/.
file(STRINGS ${PROJECT_SOURCE_DIR}/CITATION.cff cited REGEX "^version: ")
if(NOT cited STREQUAL "version: ${PROJECT_VERSION}")
    message(FATAL_ERROR "CITATION.cff names ${cited}, the project has ${PROJECT_VERSION}")
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
# A placeholder: no mail arrives at example.org. Who gives packages to others puts a name and address here (CONTRIBUTING.md).
set(CPACK_PACKAGE_CONTACT "Cellwalk developers <cellwalk@example.org>" CACHE STRING "Maintainer of packages: name and address")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_SOURCE_DIR}/debian/finish.cmake)
set(CPACK_CELLWALK_DEBIAN ${CMAKE_CURRENT_SOURCE_DIR}/debian) # finish.cmake reads what begins with CPACK_
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src/core) # libcellwalk_terrain needs libcellwalk
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL "")

# The package of a component; the description's first line is its summary. More control fields may follow.
macro(cellwalk_package component name section description)
    string(TOUPPER ${component} upper)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
    set(CPACK_COMPONENT_${upper}_DESCRIPTION "${description}")
endmacro()

if(TARGET cellwalk)
    cellwalk_package(library libcellwalk${PROJECT_VERSION_MAJOR} libs "exact ray queries on height fields - shared library
Cellwalk finds where rays hit terrain. It takes a grid of heights and any
number of rays, and returns the first hit of each ray, with the same bits
on every CPU and for any number of threads.")
    file(CONFIGURE OUTPUT debian/shlibs CONTENT "libcellwalk ${PROJECT_VERSION_MAJOR} libcellwalk${PROJECT_VERSION_MAJOR} (>= ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})\nlibcellwalk_terrain ${PROJECT_VERSION_MAJOR} libcellwalk${PROJECT_VERSION_MAJOR} (>= ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})\n")
    file(CONFIGURE OUTPUT debian/triggers CONTENT "activate-noawait ldconfig\n")
    configure_file(${CMAKE_CURRENT_SOURCE_DIR}/debian/symbols.in debian/symbols @ONLY)
    set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/debian/shlibs
        ${CMAKE_CURRENT_BINARY_DIR}/debian/symbols ${CMAKE_CURRENT_BINARY_DIR}/debian/triggers)
endif()
cellwalk_package(development libcellwalk-dev libdevel "exact ray queries on height fields - development files
Cellwalk finds where rays hit terrain. This package has the headers, the static
libraries, files for CMake and pkg-config, and the guide with an example.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
if(TARGET cellwalk)
    set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS library)
endif()
if(TARGET cellwalk_tool)
    cellwalk_package(tool cellwalk science "viewsheds, shadows and horizons of elevation models
The program cellwalk computes lines of sight, viewsheds, shadows, horizons,
sky-view factors and pictures of terrain, and traces any rays. It reads and
writes GeoTIFF, NumPy arrays and all else that GDAL knows.")
endif()
if(TARGET cellwalk_python)
    cellwalk_package(python python3-cellwalk python "exact ray queries on height fields - Python module
The module cellwalk has fields, rays, viewsheds, shadows and horizons for
NumPy arrays, xarray and rasterio, and for rasters larger than memory by Dask.")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3-cffi-backend, python3-numpy")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-xarray, python3-dask, python3-rasterio")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/debian/postinst
        ${CMAKE_CURRENT_SOURCE_DIR}/debian/prerm)
endif()
include(CPack)
