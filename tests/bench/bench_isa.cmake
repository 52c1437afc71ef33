# CELLWALK_ISA bounds cellwalk-bench as it bounds all: a name that is none is an error, and --isa cannot lift it. Argument: BENCH.
function(expect status words)
    execute_process(COMMAND ${BENCH} ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE error)
    if(NOT result EQUAL status OR NOT error MATCHES "${words}" OR NOT output STREQUAL "")
        message(FATAL_ERROR "CELLWALK_ISA=$ENV{CELLWALK_ISA} ${ARGN}: ends with ${result}\n${output}${error}")
    endif()
endfunction()

foreach(name IN ITEMS sse AVX2 "avx2 ")
    set(ENV{CELLWALK_ISA} "${name}")
    expect(2 "CELLWALK_ISA '${name}' is unknown; .*[Tt]here are scalar, sse4.2, avx2, avx512" micro)
endforeach()
set(ENV{CELLWALK_ISA} scalar)
expect(2 "--isa sse4.2: this machine, or CELLWALK_ISA, allows no more than scalar" micro --isa sse4.2)
