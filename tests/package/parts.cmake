# Optional parts: configuring says which are found and which are not, README's install command has a package for each, and
# `cellwalk --version` says which work. Arguments: SOURCE, WORK, CC, GENERATOR, TOOL, GDAL and BENCH (whether the
# build has them).
cmake_minimum_required(VERSION 3.25)

function(run expected)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${ARGN}\nended with ${result}:\n${output}")
    endif()
    if(NOT output MATCHES "${expected}")
        message(SEND_ERROR "${ARGN}\nsays nothing like '${expected}':\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

file(READ ${SOURCE}/README.md page)
string(REGEX MATCH "<!-- begin:install -->.*<!-- end:install -->" install "${page}")
file(STRINGS ${SOURCE}/src/parts.cmake rows REGEX "^ +cellwalk_part\\(")
list(LENGTH rows count)
if(count LESS 9)
    message(FATAL_ERROR "src/parts.cmake has ${count} rows")
endif()
foreach(row IN LISTS rows)
    string(REGEX REPLACE "^ +cellwalk_part\\([^ ]+ ([^ ]+) .*" "\\1" package "${row}")
    if(NOT install MATCHES " ${package} ")
        message(SEND_ERROR "README's install command has no ${package}")
    endif()
endforeach()

file(REMOVE_RECURSE ${WORK})
set(configure ${CMAKE_COMMAND} -S ${SOURCE} -G ${GENERATOR} -DCMAKE_C_COMPILER=${CC} -DCELLWALK_BENCH=OFF -DCELLWALK_TESTS=OFF)
run("Optional parts not found:.  GDAL \\(Debian: libgdal-dev\\): no GeoTIFF[^\n]*.  OpenEXR [^\n]*.  libpng " ${configure}
    -B ${WORK}/without -DCMAKE_DISABLE_FIND_PACKAGE_GDAL=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenEXR=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_PNG=ON)
if(GDAL)
    set(expected "Optional parts found: GDAL")
    if(BENCH)
        string(APPEND expected ", .*pkg-config, jansson")
    endif()
    run("${expected}" ${configure} -B ${WORK}/with -DCELLWALK_BENCH=ON)
    run("GDAL +yes" ${TOOL} --version)
endif()
run("GDAL +no.*OpenEXR +(yes|no).*libpng +(yes|no)" ${CMAKE_COMMAND} -E env CELLWALK_MODULES=/nowhere ${TOOL} --version)
