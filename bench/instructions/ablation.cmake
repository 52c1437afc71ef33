# What is each lever of the kernels worth? Builds the work of work.c from copies of the sources in each of which
# one lever is off, and counts instructions. A lever is a text that has to stand in its file exactly once, so that it cannot
# miss its mark unnoticed.
# Arguments: SOURCE (the project), FOLDER (to build in), COMPILER, GENERATOR, ABLATION (the program), RESULTS (what to write),
# FIELDS, RAYS. Without ABLATION it is only seen whether the copy can be configured and each lever's text is there.

set(copy ${FOLDER}/source)
set(build ${FOLDER}/build)
set(variants)

function(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        message(FATAL_ERROR "${ARGN}\n${output}")
    endif()
endfunction()

# variant(label kernel [file from to]...): a build with the texts replaced.
function(variant label kernel)
    message(STATUS "${label}")
    set(files)
    while(ARGN)
        list(POP_FRONT ARGN file from to)
        file(READ ${copy}/${file} text)
        string(FIND "${text}" "${from}" first)
        string(FIND "${text}" "${from}" last REVERSE)
        if(first LESS 0 OR NOT first EQUAL last)
            message(FATAL_ERROR "${label}: ${file} does not have exactly one \"${from}\"")
        endif()
        string(REPLACE "${from}" "${to}" text "${text}")
        file(WRITE ${copy}/${file} "${text}")
        list(APPEND files ${file})
    endwhile()
    list(LENGTH variants number)
    math(EXPR number "${number} / 3")
    if(ABLATION)
        run(${CMAKE_COMMAND} --build ${build} --target cellwalk_counted_work)
        file(COPY_FILE ${build}/bench/instructions/cellwalk-counted-work ${FOLDER}/work-${number})
    endif()
    foreach(file IN LISTS files)
        file(COPY_FILE ${SOURCE}/${file} ${copy}/${file})
    endforeach()
    set(variants ${variants} "${label}" ./work-${number} ${kernel} PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${copy})
foreach(part IN ITEMS CMakeLists.txt src simd include bench tests papers)
    file(COPY ${SOURCE}/${part} DESTINATION ${copy})
endforeach()
run(${CMAKE_COMMAND} -S ${copy} -B ${build} -G ${GENERATOR} -DCMAKE_C_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=Release
    -DCELLWALK_TOOL=OFF -DCELLWALK_TESTS=OFF -DCELLWALK_INSTALL=OFF)

variant("as it is" pyramid8)
variant("no sharing" pyramid8 simd/shared_walk.inc.h "SHARE_AT_LEAST = 4" "SHARE_AT_LEAST = 65")
variant("never falls apart" pyramid8 simd/shared_walk.inc.h
    "FALL_APART = 2, CHILDREN_AT_MOST = 6" "FALL_APART = 100000, CHILDREN_AT_MOST = 16")
variant("no climb" pyramid8 simd/climb.inc.h "level >= 0 && climbs != 0" "level >= 0 && false")
variant("no flat steps" pyramid8 simd/pyramid.c "FLAT_STEPS = 4" "FLAT_STEPS = 0")
variant("slabs that do not lean" pyramid8 src/core/bounds/pyramid.h "s->high - s->low + 2 * pad < high - low" "false")
set(no_cuts
    simd/lane_walk.inc.h "start = vf_min(vf_max(vf_fma(before, per, t), t), t1)" "start = vf_min(vf_max(before, t), t)"
    simd/lane_walk.inc.h "leave = vf_max(start, vf_min(vf_fnma(after, per, t1), vf_set(INFINITY)))"
    "leave = vf_max(vf_set(INFINITY), vf_add(after, per))")
variant("no cuts at slabs" pyramid8 ${no_cuts})
variant("neither leaning nor cuts" pyramid8 src/core/bounds/pyramid.h "s->high - s->low + 2 * pad < high - low" "false" ${no_cuts})
variant("refill when all lanes are empty" pyramid8 simd/lane_walk.inc.h "REFILL_AT = W < 4 ? 1 : W < 16 ? W / 4 : 4" "REFILL_AT = W")
variant("test a cell as soon as one lane waits" pyramid8 simd/lane_walk.inc.h "LEAF_AT = (3 * W + 7) / 8" "LEAF_AT = 1")
list(APPEND variants "the flat walk, packet8" ./work-0 packet8 "one ray at a time, pyramid1" ./work-0 pyramid1)

if(NOT ABLATION)
    return()
endif()
execute_process(COMMAND ${ABLATION} ablation ablation.json ${RAYS} ${FIELDS} ${variants} WORKING_DIRECTORY ${FOLDER}
    RESULT_VARIABLE status)
if(NOT status EQUAL 0)
    message(FATAL_ERROR "the variants could not be counted")
endif()
get_filename_component(folder ${RESULTS} DIRECTORY)
file(MAKE_DIRECTORY ${folder})
file(COPY_FILE ${FOLDER}/ablation.json ${RESULTS})
message(STATUS "${RESULTS}")
