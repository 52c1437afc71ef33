# The words of each row of simd/isas.cmake, as cellwalk_test_words, for tests/core/vocabulary.c: with the row's vocabulary and
# flags, and once more in vectors of two registers. A new row there needs no edit here.
add_library(cellwalk_test_words STATIC EXCLUDE_FROM_ALL)
set(cellwalk_words_targets)
set(vocabulary_rows "")
foreach(isa IN LISTS cellwalk_isas)
    foreach(registers IN ITEMS 1 2)
        string(REPLACE "x1" "" suffix ${cellwalk_${isa}_lanes}x${registers})
        set(target cellwalk_words_${suffix})
        add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_LIST_DIR}/../core/vocabulary/words.c)
        target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/simd/vocabulary ${PROJECT_SOURCE_DIR}/include)
        target_compile_definitions(${target} PRIVATE CELLWALK_VOCABULARY="vec_${isa}.h" WORDS_ROW=cw_words_${suffix}
            WORDS_SUFFIX="${suffix}" REGISTERS=${registers})
        target_compile_options(${target} PRIVATE ${cellwalk_${isa}_flags})
        target_link_libraries(${target} PRIVATE cellwalk_flags)
        target_sources(cellwalk_test_words PRIVATE $<TARGET_OBJECTS:${target}>)
        list(APPEND cellwalk_words_targets ${target})
        if(NOT suffix STREQUAL "1") # which all others are compared with
            string(APPEND vocabulary_rows "ROW(${suffix})")
        endif()
    endforeach()
endforeach()
