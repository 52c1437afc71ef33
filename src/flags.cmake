# The flags that every target of the project takes, as one interface target; and those without sanitizers as another.
add_library(cellwalk_plain_flags INTERFACE)
add_library(cellwalk_flags INTERFACE)
target_link_libraries(cellwalk_flags INTERFACE cellwalk_plain_flags)
set(safe_math)
if(CMAKE_C_COMPILER_ID STREQUAL "GNU")
    set(safe_math -fno-unsafe-math-optimizations)
endif()
target_compile_options(cellwalk_plain_flags INTERFACE
    -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wvla -Wmissing-prototypes -Wstrict-prototypes
    # A parent project's -ffast-math, -Ofast or parts of them, which stand before these, are taken back: results depend on NaN,
    # signed zeros and the order of operations. src/core/ieee.h refuses to be compiled if one is left.
    # Not by -fno-fast-math, of which Clang 14 warns where it also takes back -ffp-contract=fast; nor, with Clang, by
    # -fno-unsafe-math-optimizations, which there stands for the parts that follow and for trapping math besides.
    ${safe_math} -fno-finite-math-only -fsigned-zeros -fno-associative-math -fno-reciprocal-math
    # Compilers fuse no multiply and add: GCC fuses even separate intrinsics as soon as
    # the target has FMA, and then widths disagree in their bits.
    -ffp-contract=off
    # Square roots and the like need no errno, floating-point traps are masked; neither changes a result.
    -fno-math-errno -fno-trapping-math)
# A parent without a build type, or one that debugs itself, would else get kernels at -O0, 19 times as slow. This option stands
# behind the flags of the build type, so it wins.
if(CELLWALK_OPTIMIZE)
    target_compile_options(cellwalk_plain_flags INTERFACE -O3)
endif()
if(MINGW) # isfinite and isnan of its <math.h> convert a double to float where they never use it
    target_compile_options(cellwalk_plain_flags INTERFACE -Wno-float-conversion)
endif()
if(CELLWALK_WERROR)
    target_compile_options(cellwalk_plain_flags INTERFACE -Werror)
endif()
if(CELLWALK_SANITIZE)
    target_compile_options(cellwalk_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all
        -fno-omit-frame-pointer)
    target_link_options(cellwalk_flags INTERFACE -fsanitize=address,undefined)
endif()
# What is compiled once for each instruction set. Clang would take a minute to sanitize each of these for the fuzzers, of which one
# runs kernels and none the renderer; the kernels one lane wide are sanitized there, all of them by GCC in the preset asan-ubsan.
set(cellwalk_vector_flags cellwalk_flags)
if(CELLWALK_FUZZ) # coverage, which leads a fuzzer; its own main comes with tests/fuzz
    target_compile_options(cellwalk_flags INTERFACE -fsanitize=fuzzer-no-link)
    set(cellwalk_vector_flags cellwalk_plain_flags)
endif()
if(CELLWALK_SANITIZE_THREADS)
    target_compile_options(cellwalk_flags INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
    target_link_options(cellwalk_flags INTERFACE -fsanitize=thread)
endif()
# POSIX and the few GNU calls in use (CPU affinity, sysconf); with C extensions off they must be asked for.
target_compile_definitions(cellwalk_plain_flags INTERFACE _GNU_SOURCE)
if(CELLWALK_PORTABLE)
    target_compile_definitions(cellwalk_plain_flags INTERFACE CELLWALK_PORTABLE)
endif()

# The shared library exports the names of symbols.map beside it, with their versions, where the linker has them.
function(cellwalk_version_symbols library)
    if(UNIX AND NOT APPLE)
        set(map ${CMAKE_CURRENT_SOURCE_DIR}/symbols.map)
        target_link_options(${library} PRIVATE LINKER:--version-script=${map})
        set_target_properties(${library} PROPERTIES LINK_DEPENDS ${map})
    endif()
endfunction()
