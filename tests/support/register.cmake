# How the tests of the table in tests/CMakeLists.txt are registered. A test that cannot be built is named when configuring,
# with the reason, and ctest lists it as disabled.

# What a test may need: cellwalk_offer(WORD "why it is missing" CONDITION…), the condition as for if().
macro(cellwalk_offer word reason)
    if(${ARGN})
        set(lacks_${word} "")
    else()
        set(lacks_${word} "${reason}")
    endif()
endmacro()

# Sets result to true if all words are on offer; else registers the test as left out.
function(cellwalk_is_possible result name)
    set(${result} TRUE PARENT_SCOPE)
    foreach(word IN LISTS ARGN)
        if(NOT DEFINED lacks_${word})
            message(FATAL_ERROR "${name} needs ${word}, which nothing offers")
        endif()
        if(lacks_${word})
            add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -E false)
            set_tests_properties(${name} PROPERTIES DISABLED TRUE)
            set_property(GLOBAL APPEND PROPERTY cellwalk_left_out_why ${word})
            set_property(GLOBAL APPEND PROPERTY cellwalk_left_out_for_${word} ${name})
            set(${result} FALSE PARENT_SCOPE)
            return()
        endif()
    endforeach()
endfunction()

function(cellwalk_tell_left_out)
    get_property(words GLOBAL PROPERTY cellwalk_left_out_why)
    list(REMOVE_DUPLICATES words)
    foreach(word IN LISTS words)
        get_property(names GLOBAL PROPERTY cellwalk_left_out_for_${word})
        list(JOIN names ", " names)
        message(STATUS "Tests left out, ${lacks_${word}}: ${names}")
    endforeach()
endfunction()

# Slow: tests with random parts run a tenth of their rays.
set(scale_down 1)
if(CELLWALK_SANITIZE OR CELLWALK_SANITIZE_THREADS OR CMAKE_BUILD_TYPE STREQUAL "Debug" OR CMAKE_CROSSCOMPILING)
    set(scale_down 10)
endif()

# A row of the table: the cmocka program test_NAME from sources in FOLDER, and the test NAME that runs it, with FOLDER as label.
#   SOURCES file…   in FOLDER
#   LINKS target…   beside cmocka and the library
#   NEEDS word…     beside cmocka
#   RUNS target     the program that the test starts, as CELLWALK_PROGRAM
#   AFTER target…   what else has to be built first
#   DEFINES a=b…    for its sources
#   KERNELS share   its outcome may depend on which kernels the machine has. So it gets the label kernels, and a twin
#                   NAME_avx512_emulated (emulated.cmake) with one ray in that many where it makes rays by the number; 0: none
#   TWIN            the twin has the label emulated; other twins have the label long. The target of that name builds it, all does
#                   not, and the preset of that name runs it
#   PARTS "test n pattern…"…   tests of these names run the program's rows that match the patterns (rows.h) and take n seconds; there
#                   is no test NAME
#   SECONDS n       of CPU time, if it is long: the longest start first
function(cellwalk_test folder name)
    cmake_parse_arguments(PARSE_ARGV 2 row "TWIN" "RUNS;KERNELS;SECONDS" "SOURCES;LINKS;NEEDS;AFTER;DEFINES;PARTS")
    if(row_UNPARSED_ARGUMENTS OR NOT row_SOURCES)
        message(FATAL_ERROR "${name}: ${row_UNPARSED_ARGUMENTS} is none of a row's words, or sources are missing")
    endif()
    list(TRANSFORM row_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/ REGEX "^[^$]")
    set(tests ${name})
    if(row_PARTS)
        list(TRANSFORM row_PARTS REPLACE " .*" "" OUTPUT_VARIABLE tests)
    endif()
    set(labels ${folder})
    if(DEFINED row_KERNELS)
        list(APPEND labels kernels)
    endif()
    foreach(test IN LISTS tests)
        cellwalk_is_possible(possible ${test} cmocka ${row_NEEDS})
    endforeach()
    if(possible)
        cellwalk_add_program(${name} "${row_RUNS}" ${row_LINKS})
        foreach(part IN LISTS row_PARTS)
            string(REGEX MATCH "^([^ ]+) ([0-9]+) (.*)$" part "${part}")
            set(row_SECONDS ${CMAKE_MATCH_2})
            add_test(NAME ${CMAKE_MATCH_1} COMMAND test_${name} ${CMAKE_MATCH_3})
            cellwalk_limit_time(${CMAKE_MATCH_1})
        endforeach()
        set_tests_properties(${tests} PROPERTIES LABELS "${labels}")
        if(folder MATCHES "^(core|io|scene|terrain|faults)$")
            add_dependencies(tests_of_libraries test_${name})
        endif()
    endif()
    set(row_PARTS)
    if(row_KERNELS)
        set(twin ${name}_avx512_emulated)
        cellwalk_is_possible(possible ${twin} cmocka ${row_NEEDS} emulation)
        if(possible)
            if(row_RUNS)
                cellwalk_emulated_twin(${row_RUNS})
                string(APPEND row_RUNS _emulated)
            endif()
            cellwalk_add_program(${twin} "${row_RUNS}" cellwalk_emulated ${row_LINKS})
            set_tests_properties(${twin} PROPERTIES ENVIRONMENT CELLWALK_TEST_DIVIDE=${row_KERNELS} LABELS emulated)
            set_target_properties(test_${twin} PROPERTIES EXCLUDE_FROM_ALL ON)
            if(row_TWIN)
                add_dependencies(emulated test_${twin})
            else()
                set_tests_properties(${twin} PROPERTIES LABELS long)
                add_dependencies(long test_${twin})
            endif()
        endif()
    endif()
endfunction()

# The programs that test libraries and start no other.
add_custom_target(tests_of_libraries)
# What only the presets emulated and long run.
add_custom_target(emulated)
add_custom_target(long)

# The tests of the preset quick.
function(cellwalk_quick)
    foreach(name IN LISTS ARGN)
        if(NOT TEST ${name})
            message(FATAL_ERROR "there is no test ${name}")
        endif()
        set_property(TEST ${name} APPEND PROPERTY LABELS quick)
    endforeach()
endfunction()

# Takes the row from cellwalk_test.
function(cellwalk_add_program name program)
    set(target test_${name})
    add_executable(${target} ${row_SOURCES})
    target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
    target_link_libraries(${target} PRIVATE ${ARGN} cellwalk_test_support cellwalk_flags)
    target_compile_definitions(${target} PRIVATE TEST_SCALE_DOWN=${scale_down})
    if(CMAKE_CROSSCOMPILING) # an emulator's memory is its own, and QEMU 7.2 fails where a forked child starts threads
        target_compile_definitions(${target} PRIVATE TEST_IN_EMULATOR)
    endif()
    target_compile_definitions(${target} PRIVATE ${row_DEFINES})
    if(program)
        target_compile_definitions(${target} PRIVATE CELLWALK_PROGRAM="$<TARGET_FILE:${program}>")
        add_dependencies(${target} ${program})
    endif()
    if(row_AFTER)
        add_dependencies(${target} ${row_AFTER})
    endif()
    if(NOT row_PARTS)
        add_test(NAME ${name} COMMAND ${target})
        cellwalk_limit_time(${name})
    endif()
endfunction()

# Takes SECONDS from the row of its caller.
function(cellwalk_limit_time name)
    set_tests_properties(${name} PROPERTIES TIMEOUT 900) # a hang, not a slow or busy machine
    if(row_SECONDS)
        set_tests_properties(${name} PROPERTIES COST ${row_SECONDS})
    endif()
endfunction()

# A row for tool/test_NAME.py, which starts the program: the test tool_NAME. KERNELS and SECONDS as of cellwalk_test, but that a twin
# starts the program with emulated kernels. One in which pytest skips a test counts as skipped, and says which.
add_executable(cellwalk_test_library ${CMAKE_CURRENT_LIST_DIR}/../tool/library.c)
target_link_libraries(cellwalk_test_library PRIVATE cellwalk_reference cellwalk_flags m)
function(cellwalk_tool_test name)
    cmake_parse_arguments(PARSE_ARGV 1 row "" "KERNELS;SECONDS" "NEEDS")
    cellwalk_add_tool_test(tool_${name} "" tool ${row_NEEDS})
    if(DEFINED row_KERNELS AND TEST tool_${name})
        set_property(TEST tool_${name} APPEND PROPERTY LABELS kernels)
    endif()
    if(row_KERNELS)
        if(NOT lacks_emulation AND NOT lacks_tool)
            foreach(program IN ITEMS cellwalk_tool cellwalk_test_library)
                cellwalk_emulated_twin(${program})
                add_dependencies(long ${program}_emulated)
            endforeach()
        endif()
        cellwalk_add_tool_test(tool_${name}_avx512_emulated _emulated long ${row_NEEDS} emulation)
    endif()
endfunction()

# Takes name and row from its caller.
function(cellwalk_add_tool_test test twin label)
    cellwalk_is_possible(possible ${test} native tool numpy pytest ${ARGN})
    if(possible)
        add_test(NAME ${test} WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/tool
            COMMAND ${interpreter} -B -m pytest -q -rs -p no:cacheprovider test_${name}.py)
        set(environment CELLWALK_PROGRAM=$<TARGET_FILE:cellwalk_tool${twin}> CELLWALK_LIBRARY=$<TARGET_FILE:cellwalk_test_library${twin}>
            CELLWALK_SOURCE=${PROJECT_SOURCE_DIR} CELLWALK_TEST_SLOW=${scale_down})
        if(TARGET cellwalk_test_preload)
            list(APPEND environment CELLWALK_PRELOAD=$<TARGET_FILE:cellwalk_test_preload>)
        endif()
        if(TARGET cellwalk_bench)
            list(APPEND environment CELLWALK_BENCH=$<TARGET_FILE:cellwalk_bench>)
        endif()
        if(TARGET cellwalk_gdal)
            list(APPEND environment CELLWALK_MODULES=$<TARGET_FILE_DIR:cellwalk_gdal>)
        endif()
        set_tests_properties(${test} PROPERTIES LABELS ${label} SKIP_REGULAR_EXPRESSION "SKIPPED \\[" ENVIRONMENT "${environment}")
        cellwalk_limit_time(${test})
    endif()
endfunction()

# A row for a CMake script in FOLDER, which prints SKIPPED where it finds that it cannot run.
#   SCRIPT file, WITH name=value…, NEEDS word…, SECONDS n, ONCE if neither compiler nor sanitizers can change its outcome: it gets
#   the label once, and presets other than ci leave it out
function(cellwalk_script_test folder name)
    cmake_parse_arguments(PARSE_ARGV 2 row "ONCE" "SCRIPT;SECONDS" "WITH;NEEDS")
    if(row_UNPARSED_ARGUMENTS OR NOT row_SCRIPT)
        message(FATAL_ERROR "${name}: ${row_UNPARSED_ARGUMENTS} is none of a row's words, or the script is missing")
    endif()
    cellwalk_is_possible(possible ${name} ${row_NEEDS})
    if(NOT possible)
        return()
    endif()
    list(TRANSFORM row_WITH PREPEND -D)
    cmake_path(ABSOLUTE_PATH row_SCRIPT BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
    add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} ${row_WITH} -P ${row_SCRIPT})
    set_tests_properties(${name} PROPERTIES SKIP_REGULAR_EXPRESSION SKIPPED)
    if(row_ONCE)
        set_tests_properties(${name} PROPERTIES LABELS once)
    endif()
    cellwalk_limit_time(${name})
endfunction()

# A row for a function of package/test_package.py: NAME's or FUNCTION's, with name=value… as environment. NEEDS, SECONDS and ONCE as
# above.
function(cellwalk_package_test name)
    cmake_parse_arguments(PARSE_ARGV 1 row "ONCE" "FUNCTION;SECONDS" "WITH;NEEDS")
    cellwalk_is_possible(possible ${name} pytest ${row_NEEDS})
    if(NOT possible)
        return()
    endif()
    if(NOT row_FUNCTION)
        set(row_FUNCTION ${name})
    endif()
    add_test(NAME ${name} WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/package
        COMMAND ${interpreter} -B -m pytest -q -rs -p no:cacheprovider test_package.py::test_${row_FUNCTION})
    set_tests_properties(${name} PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED \\[" ENVIRONMENT
        "SOURCE=${PROJECT_SOURCE_DIR};CMAKE=${CMAKE_COMMAND};GENERATOR=${CMAKE_GENERATOR};CC=${CMAKE_C_COMPILER};${row_WITH}")
    if(row_ONCE)
        set_tests_properties(${name} PROPERTIES LABELS once)
    endif()
    cellwalk_limit_time(${name})
endfunction()

# A row for any other command: COMMAND word…, IN folder, NEEDS word…, SECONDS n, ONCE as above, SKIPS if it exits with 77 where
# it finds that it cannot run; properties may be added after it.
function(cellwalk_command_test name)
    cmake_parse_arguments(PARSE_ARGV 1 row "ONCE;SKIPS" "IN;SECONDS" "COMMAND;NEEDS")
    cellwalk_is_possible(possible ${name} ${row_NEEDS})
    if(NOT row_IN)
        set(row_IN ${CMAKE_CURRENT_BINARY_DIR})
    endif()
    if(possible)
        add_test(NAME ${name} COMMAND ${row_COMMAND} WORKING_DIRECTORY ${row_IN})
        if(row_SKIPS)
            set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77)
        endif()
        if(row_ONCE)
            set_tests_properties(${name} PROPERTIES LABELS once)
        endif()
        cellwalk_limit_time(${name})
    endif()
endfunction()
