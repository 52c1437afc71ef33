# Cellwalk as a part of another project, as a static and as a shared library: configures, builds, runs, and installs nothing of
# its own. The parent is compiled with -ffast-math, which Cellwalk takes back for itself. Arguments: SOURCE, PARENT, WORK, CC, GENERATOR.
cmake_minimum_required(VERSION 3.25)
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

# The static build is what comes without a word about it. The shared one does without the vector kernels, to be built sooner.
# Without optimisation -ffast-math changes little, but then src/core/ieee.h sees it in every kernel.
set(static -DCMAKE_C_FLAGS=-ffast-math)
set(shared -DBUILD_SHARED_LIBS=ON -DCELLWALK_SIMD=OFF "-DCMAKE_C_FLAGS=-O1 -ffast-math -ffinite-math-only -funsafe-math-optimizations")
foreach(kind IN ITEMS static shared)
    run(${CMAKE_COMMAND} -S ${PARENT} -B ${kind} -G ${GENERATOR} -DCMAKE_C_COMPILER=${CC} -DCELLWALK=${SOURCE} ${${kind}})
    run(${CMAKE_COMMAND} --build ${kind})
    file(GLOB_RECURSE libraries ${WORK}/${kind}/*.so)
    if((kind STREQUAL "shared" AND NOT libraries) OR (kind STREQUAL "static" AND libraries))
        message(FATAL_ERROR "${kind}: shared libraries: ${libraries}")
    endif()
    foreach(program IN ITEMS consumer fast_math)
        run(${WORK}/${kind}/${program})
        message(STATUS "${kind}: ${output}")
    endforeach()
    run(${CMAKE_COMMAND} --install ${kind} --prefix ${WORK}/${kind}-tree)
    file(GLOB_RECURSE installed RELATIVE ${WORK}/${kind}-tree ${WORK}/${kind}-tree/*)
    if(NOT installed STREQUAL "bin/consumer")
        message(FATAL_ERROR "${kind}: installed are ${installed}")
    endif()
endforeach()
