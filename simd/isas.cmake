# The instruction sets of the kernels (simd/CMakeLists.txt) and of the renderer's tiles (src/scene/CMakeLists.txt), one a row, from
# the narrowest on: name, lanes of a register, compiler flags. The vocabulary is vocabulary/vec_NAME.h, the value of cw_isa is
# CW_ISA_ and the name in capitals.
set(cellwalk_isas)
macro(cellwalk_isa name lanes)
    list(APPEND cellwalk_isas ${name})
    set(cellwalk_${name}_lanes ${lanes})
    set(cellwalk_${name}_flags ${ARGN})
endmacro()

cellwalk_isa(scalar 1)
if(CELLWALK_SIMD AND aarch64)
    cellwalk_isa(neon 4)
elseif(CELLWALK_SIMD)
    cellwalk_isa(sse42 4 -msse4.2)
    cellwalk_isa(avx2 8 -mavx2 -mbmi -mbmi2)
    cellwalk_isa(avx512 16 -mbmi -mbmi2 -mavx512f -mavx512vl -mavx512dq -mavx512bw)
endif()
