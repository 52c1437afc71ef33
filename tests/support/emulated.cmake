# AVX-512 for machines without it: every kernel that is compiled for it, compiled once more for AVX2 with its intrinsics
# carried out by SIMDe; and so the renderer's tiles, which have none. A program that links cellwalk_emulated takes these
# objects in place of the library's, which the linker then has no reason to take, and believes that the machine has AVX-512
# if it has AVX2. So the kernels 16 lanes wide are tested on every machine, and every test can be run as it runs on a machine
# with AVX-512.

find_path(SIMDE_INCLUDE simde/x86/avx512.h)
set(no_emulation "")
if(NOT CELLWALK_SIMD OR NOT x86_64)
    set(no_emulation "there are no AVX-512 kernels to emulate")
elseif(CELLWALK_SANITIZE OR CELLWALK_SANITIZE_THREADS OR NOT CMAKE_C_COMPILER_ID STREQUAL "GNU")
    set(no_emulation "AVX-512 is emulated in builds by GCC without sanitizers alone")
elseif(NOT SIMDE_INCLUDE)
    set(no_emulation "SIMDe (Debian: libsimde-dev), which emulates AVX-512, not found")
endif()
if(no_emulation)
    return()
endif()

add_library(cellwalk_emulated_isa OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/src/core/dispatch/isa.c)
target_include_directories(cellwalk_emulated_isa PRIVATE ${PROJECT_SOURCE_DIR}/include ${cellwalk_core_headers})
target_compile_definitions(cellwalk_emulated_isa PRIVATE CELLWALK_EMULATES_AVX512)
target_link_libraries(cellwalk_emulated_isa PRIVATE cellwalk_flags)

add_library(cellwalk_emulated INTERFACE)
target_sources(cellwalk_emulated INTERFACE $<TARGET_OBJECTS:cellwalk_emulated_isa>)
# For a test that writes down what it has run.
target_compile_definitions(cellwalk_emulated INTERFACE CELLWALK_EMULATES_AVX512)

get_property(kernels DIRECTORY ${PROJECT_SOURCE_DIR}/simd PROPERTY BUILDSYSTEM_TARGETS)
foreach(kernel IN LISTS kernels cellwalk_words_targets ITEMS cellwalk_tile_avx512)
    get_target_property(options ${kernel} COMPILE_OPTIONS)
    if(NOT options MATCHES "-mavx512")
        continue()
    endif()
    get_target_property(sources ${kernel} SOURCES)
    get_target_property(folder ${kernel} SOURCE_DIR)
    list(TRANSFORM sources PREPEND ${folder}/ REGEX "^[^/$]")
    add_library(${kernel}_emulated OBJECT EXCLUDE_FROM_ALL ${sources})
    target_include_directories(${kernel}_emulated PRIVATE $<TARGET_PROPERTY:${kernel},INCLUDE_DIRECTORIES>)
    target_include_directories(${kernel}_emulated SYSTEM PRIVATE ${SIMDE_INCLUDE})
    target_compile_definitions(${kernel}_emulated PRIVATE $<TARGET_PROPERTY:${kernel},COMPILE_DEFINITIONS>)
    target_sources(cellwalk_emulated INTERFACE $<TARGET_OBJECTS:${kernel}_emulated>)
    # The flags of src/flags.cmake that change code, without the warnings, for SIMDe's inline functions. Vectors wider than
    # the machine's are passed in memory, of which GCC warns; all of it is one compile unit. -O3 takes four times as long to compile.
    target_compile_options(${kernel}_emulated PRIVATE -mavx2 -O1 -ffp-contract=off -fno-math-errno -fno-trapping-math
        -Wno-psabi -include ${CMAKE_CURRENT_LIST_DIR}/emulated_avx512.h)
endforeach()
# What the tiles call, also in programs that render nothing.
target_link_libraries(cellwalk_emulated INTERFACE cellwalk_scene)

# The same program with emulated kernels: ${program}_emulated.
function(cellwalk_emulated_twin program)
    if(TARGET ${program}_emulated)
        return()
    endif()
    get_target_property(folder ${program} SOURCE_DIR)
    get_target_property(sources ${program} SOURCES)
    get_target_property(libraries ${program} LINK_LIBRARIES)
    list(TRANSFORM sources PREPEND ${folder}/ REGEX "^[^/$]")
    add_executable(${program}_emulated EXCLUDE_FROM_ALL ${sources})
    target_include_directories(${program}_emulated PRIVATE ${folder} $<TARGET_PROPERTY:${program},INCLUDE_DIRECTORIES>)
    target_compile_definitions(${program}_emulated PRIVATE $<TARGET_PROPERTY:${program},COMPILE_DEFINITIONS>)
    target_link_libraries(${program}_emulated PRIVATE cellwalk_emulated ${libraries})
endfunction()
