# Installs the build into a fresh tree, moves the tree, and builds and runs the consumer against it, once through the CMake
# package and once through pkg-config, linked as it comes and statically. Arguments: BUILD, WORK, CONSUMER, CC, CONFIG, GENERATOR.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run)
    execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output
        ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        list(JOIN ARGN " " command)
        message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/tree) # nothing may know where it was installed to

run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/tree
    -DCMAKE_C_COMPILER=${CC} -DCMAKE_BUILD_TYPE=${CONFIG})
run(${CMAKE_COMMAND} --build ${WORK}/build)
foreach(program IN ITEMS consumer consumer_static)
    run(${WORK}/build/${program})
    message(STATUS "CMake package, ${program}: ${output}")
endforeach()

find_program(PKG_CONFIG pkg-config)
if(NOT PKG_CONFIG)
    message(STATUS "SKIPPED: without pkg-config (Debian: pkg-config) its file is not tested")
    return()
endif()
file(GLOB_RECURSE files ${WORK}/tree/cellwalk.pc)
list(GET files 0 pc)
get_filename_component(directory ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${directory})
get_filename_component(libraries ${directory} DIRECTORY)
foreach(kind IN ITEMS shared static)
    set(static_flag)
    if(kind STREQUAL static)
        set(static_flag --static)
    endif()
    run(${PKG_CONFIG} --cflags --libs ${static_flag} cellwalk)
    separate_arguments(flags UNIX_COMMAND "${output}")
    string(REPLACE "--static" "-static" link "${static_flag}")
    run(${CC} -std=c17 ${link} ${CONSUMER}/consumer.c -o ${WORK}/pkg-${kind} ${flags})
    run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${libraries} ${WORK}/pkg-${kind})
    message(STATUS "pkg-config, ${kind}: ${output}")
endforeach()
