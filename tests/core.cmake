# Tests of the tracing core.

# Makes a test take the emulated kernels for the machine's, as described below.
function(cellwalk_emulate test)
    target_include_directories(test_${test} PRIVATE ${PROJECT_SOURCE_DIR}/src/core)
    target_compile_definitions(test_${test} PRIVATE CELLWALK_MACHINE_ISA=CW_ISA_AVX512)
    target_link_libraries(test_${test} PRIVATE cellwalk_test_rays)
endfunction()

find_package(Threads REQUIRED)
if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    add_library(cellwalk_test_rays STATIC fields.c paths.c rays.c)
    target_include_directories(cellwalk_test_rays PRIVATE ${CMOCKA_INCLUDE})
    target_link_libraries(cellwalk_test_rays PUBLIC cellwalk_workload PRIVATE cellwalk_flags ${CMOCKA_LIBRARY})

    cellwalk_test(api api.c)
    target_link_libraries(test_api PRIVATE cellwalk_test_rays)
    cellwalk_test(environment environment.c)
    target_link_libraries(test_environment PRIVATE cellwalk_test_rays Threads::Threads)
    cellwalk_test(lanes lanes.c)
    target_link_libraries(test_lanes PRIVATE cellwalk_test_rays)

    # The same with AVX-512 emulated, for the machines without it: these objects stand in for the library's own, which
    # the linker then has no reason to take. The rest of such a build needs AVX2.
    find_path(SIMDE_INCLUDE simde/x86/avx512.h)
    if(CELLWALK_SIMD AND SIMDE_INCLUDE AND CMAKE_C_COMPILER_ID STREQUAL "GNU" AND NOT CELLWALK_SANITIZE)
        add_library(cellwalk_emulated OBJECT ${PROJECT_SOURCE_DIR}/simd/packet16.c ${PROJECT_SOURCE_DIR}/simd/pyramid16.c
            ${PROJECT_SOURCE_DIR}/simd/near16.c)
        target_include_directories(cellwalk_emulated PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src/core)
        target_include_directories(cellwalk_emulated SYSTEM PRIVATE ${SIMDE_INCLUDE})
        # Vectors wider than the machine's are passed in memory, of which GCC warns; all of it is one compile unit.
        target_compile_options(cellwalk_emulated PRIVATE -mavx2 -mfma -ffp-contract=off -fno-math-errno -fno-trapping-math
            -Wno-psabi -include ${CMAKE_CURRENT_SOURCE_DIR}/emulated_avx512.h)
        set(emulated ${PROJECT_SOURCE_DIR}/src/core/isa.c $<TARGET_OBJECTS:cellwalk_emulated>)
        cellwalk_test(lanes_avx512_emulated lanes.c ${emulated})
        cellwalk_emulate(lanes_avx512_emulated)
    else()
        message(STATUS "Kernels for AVX-512 are tested only where the CPU has it (emulation: libsimde-dev, GCC, no sanitizer)")
    endif()
endif()

# Old CPUs, emulated: up to SSE3, SSE4.2, AVX2.
find_program(QEMU qemu-x86_64)
if(QEMU AND TARGET test_lanes AND NOT CELLWALK_SANITIZE AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    foreach(cpu IN ITEMS core2duo Nehalem Haswell)
        add_test(NAME lanes_${cpu} COMMAND ${CMAKE_COMMAND} -DQEMU=${QEMU} -DCPU=${cpu} -DTEST=$<TARGET_FILE:test_lanes>
            -DLOG=${CMAKE_CURRENT_BINARY_DIR}/lanes_${cpu}.log -DSIMD=${CELLWALK_SIMD}
            -P ${CMAKE_CURRENT_SOURCE_DIR}/old_cpu.cmake)
        set_tests_properties(lanes_${cpu} PROPERTIES TIMEOUT 300 SKIP_REGULAR_EXPRESSION "SKIPPED")
    endforeach()
endif()

if(CMOCKA_INCLUDE AND CMOCKA_LIBRARY AND GMP_INCLUDE AND GMP_LIBRARY)
    add_library(cellwalk_test_oracle STATIC doubt.c exact.c judge.c oracle.c tally.c)
    target_include_directories(cellwalk_test_oracle PUBLIC ${GMP_INCLUDE} ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(cellwalk_test_oracle PRIVATE cellwalk_flags PUBLIC cellwalk_test_rays ${GMP_LIBRARY} m)

    cellwalk_test(oracle oracle_test.c)
    target_link_libraries(test_oracle PRIVATE cellwalk_test_oracle)
    foreach(test IN ITEMS brute exhaustive tolerance watertight)
        cellwalk_test(${test} ${test}.c)
        target_link_libraries(test_${test} PRIVATE cellwalk_test_oracle)
    endforeach()
    cellwalk_test(extremes extremes.c extremes_judge.c)
    target_link_libraries(test_extremes PRIVATE cellwalk_test_oracle)
    if(TARGET cellwalk_emulated)
        cellwalk_test(extremes_avx512_emulated extremes.c extremes_judge.c ${emulated})
        cellwalk_emulate(extremes_avx512_emulated)
        target_link_libraries(test_extremes_avx512_emulated PRIVATE cellwalk_test_oracle)
    endif()

    if(TARGET cellwalk_emulated) # see lanes_avx512_emulated
        cellwalk_test(tolerance_avx512_emulated tolerance.c ${PROJECT_SOURCE_DIR}/src/core/isa.c
            $<TARGET_OBJECTS:cellwalk_emulated>)
        target_include_directories(test_tolerance_avx512_emulated PRIVATE ${PROJECT_SOURCE_DIR}/src/core)
        target_compile_definitions(test_tolerance_avx512_emulated PRIVATE CELLWALK_MACHINE_ISA=CW_ISA_AVX512)
        target_link_libraries(test_tolerance_avx512_emulated PRIVATE cellwalk_test_oracle)
        set_tests_properties(tolerance_avx512_emulated PROPERTIES ENVIRONMENT CELLWALK_TEST_DIVIDE=16)
    endif()

    cellwalk_test(stress stress.c)
    target_link_libraries(test_stress PRIVATE cellwalk_test_rays cellwalk_workload)
    cellwalk_test(stability stability_test.c)
    target_link_libraries(test_stability PRIVATE cellwalk_stability_run)
endif()

# The installed library, and what leaves it. Sanitizers add symbols and need their flags in the consumer too.
if(NOT CELLWALK_SANITIZE)
    add_test(NAME install COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR}
        -DWORK=${CMAKE_CURRENT_BINARY_DIR}/install -DCONSUMER=${CMAKE_CURRENT_SOURCE_DIR}/consumer
        -DCC=${CMAKE_C_COMPILER} -DCONFIG=${CMAKE_BUILD_TYPE} -DGENERATOR=${CMAKE_GENERATOR}
        -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/install.cmake)
    add_test(NAME symbols COMMAND ${CMAKE_COMMAND} "-DSHARED=$<$<TARGET_EXISTS:cellwalk>:$<TARGET_FILE:cellwalk::cellwalk>>"
        -DSTATIC=$<TARGET_FILE:cellwalk::cellwalk_static> -DNM=${CMAKE_NM} -DOBJDUMP=${CMAKE_OBJDUMP} -DSIMD=${CELLWALK_SIMD}
        -P ${CMAKE_CURRENT_SOURCE_DIR}/symbols.cmake)
    set_tests_properties(symbols PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED")
endif()
