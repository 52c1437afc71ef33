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

function(cellwalk_tell_left_out)
    get_property(words GLOBAL PROPERTY cellwalk_left_out_why)
    list(REMOVE_DUPLICATES words)
    foreach(word IN LISTS words)
        get_property(names GLOBAL PROPERTY cellwalk_left_out_for_${word})
        list(JOIN names ", " names)
        message(STATUS "Tests left out, ${lacks_${word}}: ${names}")
    endforeach()
endfunction()

# Registers the test NAME.
#   COMMAND word…          its program, which runs IN folder
#   NEEDS word…            what it cannot do without
#   LABELS label…, ENVIRONMENT name=value…
#   SECONDS n              of CPU time, if it is long: the longest start first
#   ONCE                   neither compiler nor sanitizers can change its outcome: it gets the label once, and presets other than ci
#                          leave it out
#   SKIPS 77 or pattern    the status with which it ends, or what it prints, where it finds that it cannot run
#   LATE program           which all does not build: where it is missing, the test is skipped
#   RESULT variable        true if it is not left out
function(cellwalk_register name)
    cmake_parse_arguments(PARSE_ARGV 1 test "ONCE" "IN;SECONDS;SKIPS;LATE;RESULT" "COMMAND;NEEDS;LABELS;ENVIRONMENT")
    if(test_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "${name}: ${test_UNPARSED_ARGUMENTS} is none of a row's words")
    endif()
    set(possible TRUE)
    foreach(word IN LISTS test_NEEDS)
        if(NOT DEFINED lacks_${word})
            message(FATAL_ERROR "${name} needs ${word}, which nothing offers")
        endif()
        if(possible AND lacks_${word})
            set(possible FALSE)
            add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -E false)
            set_tests_properties(${name} PROPERTIES DISABLED TRUE)
            set_property(GLOBAL APPEND PROPERTY cellwalk_left_out_why ${word})
            set_property(GLOBAL APPEND PROPERTY cellwalk_left_out_for_${word} ${name})
        endif()
    endforeach()
    if(test_RESULT)
        set(${test_RESULT} ${possible} PARENT_SCOPE)
    endif()
    if(NOT possible)
        return()
    endif()
    if(NOT test_IN)
        set(test_IN ${CMAKE_CURRENT_BINARY_DIR})
    endif()
    if(test_ONCE)
        list(APPEND test_LABELS once)
    endif()
    if(test_LATE)
        list(PREPEND test_COMMAND sh -c "[ -x \"$0\" ] && exec \"$@\" || echo \"not built: $0\" && exit 77" ${test_LATE})
    endif()
    add_test(NAME ${name} COMMAND ${test_COMMAND} WORKING_DIRECTORY ${test_IN})
    # What takes so long hangs; it is not a slow or busy machine.
    set_tests_properties(${name} PROPERTIES TIMEOUT 900 LABELS "${test_LABELS}" ENVIRONMENT "${test_ENVIRONMENT}" COST "${test_SECONDS}")
    if(test_SKIPS STREQUAL 77 OR test_LATE)
        set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77)
    endif()
    if(test_SKIPS AND NOT test_SKIPS STREQUAL 77)
        set_tests_properties(${name} PROPERTIES SKIP_REGULAR_EXPRESSION ${test_SKIPS})
    endif()
endfunction()

# The same for a file of pytest's in FOLDER, or one of its functions. It counts as skipped if pytest skips one of its tests and none
# fails (ctest looks for the text before it looks at the exit status), and says which.
macro(cellwalk_run_pytest name folder file)
    cellwalk_register(${name} ${ARGN} IN ${CMAKE_CURRENT_SOURCE_DIR}/${folder} SKIPS "\n([0-9]+ passed, )?[0-9]+ skipped(, [0-9]+ (deselected|warnings?))* in "
        COMMAND ${interpreter} -B -m pytest -q -rs -p no:cacheprovider ${file})
endmacro()

# Slow: tests with random parts run a tenth of their rays.
set(scale_down 1)
if(CELLWALK_SANITIZE OR CELLWALK_SANITIZE_THREADS OR CMAKE_BUILD_TYPE STREQUAL "Debug" OR CMAKE_CROSSCOMPILING)
    set(scale_down 10)
endif()

# A row of the table: the cmocka program test_NAME from sources in FOLDER, and the test NAME that runs it, with FOLDER as label.
#   SOURCES file…   in FOLDER
#   LINKS target…   beside cmocka and the library
#   NEEDS word…     beside cmocka
#   DEFINES a=b…    for its sources
#   KERNELS share   its outcome may depend on which kernels the machine has. So it gets the label kernels, and a twin
#                   NAME_avx512_emulated (emulated.cmake) with one ray in that many where it makes rays by the number; 0: none
#   TWIN            the twin has the label emulated; other twins have the label long. The target of that name builds it, all does
#                   not, and the preset of that name runs it
#   SECONDS n       as above
function(cellwalk_test folder name)
    cmake_parse_arguments(PARSE_ARGV 2 row "TWIN" "KERNELS;SECONDS" "SOURCES;LINKS;NEEDS;DEFINES")
    if(row_UNPARSED_ARGUMENTS OR NOT row_SOURCES)
        message(FATAL_ERROR "${name}: ${row_UNPARSED_ARGUMENTS} is none of a row's words, or sources are missing")
    endif()
    list(TRANSFORM row_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/ REGEX "^[^$]")
    set(labels ${folder})
    if(DEFINED row_KERNELS)
        list(APPEND labels kernels)
    endif()
    cellwalk_register(${name} COMMAND test_${name} NEEDS cmocka ${row_NEEDS} LABELS ${labels} SECONDS ${row_SECONDS} RESULT possible)
    if(possible)
        add_executable(test_${name} ${row_SOURCES})
        target_include_directories(test_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
        target_link_libraries(test_${name} PRIVATE ${row_LINKS} cellwalk_test_support cellwalk_flags)
        target_compile_definitions(test_${name} PRIVATE ${row_DEFINES})
        if(folder MATCHES "^(core|io|scene|terrain|faults)$")
            add_dependencies(tests_of_libraries test_${name})
        endif()
    endif()
    if(row_KERNELS)
        set(kind long)
        if(row_TWIN)
            set(kind emulated)
        endif()
        set(twin $<TARGET_FILE:test_${name}_emulated>)
        cellwalk_register(${name}_avx512_emulated COMMAND ${twin} LATE ${twin} NEEDS cmocka ${row_NEEDS} emulation LABELS ${kind}
            SECONDS ${row_SECONDS} ENVIRONMENT CELLWALK_TEST_DIVIDE=${row_KERNELS} RESULT possible)
        if(possible)
            cellwalk_emulated_twin(test_${name})
            add_dependencies(${kind} test_${name}_emulated)
        endif()
    endif()
endfunction()

# The programs that test libraries and start no other, for presets that leave out what each compiler computes alike.
add_custom_target(tests_of_libraries)
# What only the presets emulated and long run.
add_custom_target(emulated)
add_custom_target(long)

# A row for FOLDER/test_NAME.py: the test FOLDER_NAME, with FOLDER as label, which NEEDS pytest and needs_FOLDER, and in its ENVIRONMENT has
# that of all (CMakeLists.txt).
#   COMMA           also in a locale with a decimal comma
#   PROGRAM target  what it starts, whose kernels may decide: it gets the label kernels, and a twin with the label long that starts the
#                   same program with emulated kernels
function(cellwalk_pytest folder name)
    cmake_parse_arguments(PARSE_ARGV 2 row "COMMA" "PROGRAM" "NEEDS;ENVIRONMENT")
    set(test ${folder}_${name})
    set(words ${folder} test_${name}.py ${row_UNPARSED_ARGUMENTS} NEEDS pytest ${needs_${folder}} ${row_NEEDS} ENVIRONMENT ${environment} ${row_ENVIRONMENT})
    if(NOT folder MATCHES "^(python|bench)$") # where it is to be found beside the program
        list(APPEND words ${modules})
    endif()
    cellwalk_run_pytest(${test} ${words} LABELS ${folder} $<$<BOOL:${row_PROGRAM}>:kernels>)
    if(row_COMMA)
        cellwalk_run_pytest(${test}_comma ${words} ${with_comma} NEEDS native comma LABELS ${folder})
    endif()
    if(row_PROGRAM)
        set(twin $<TARGET_FILE:${row_PROGRAM}_emulated>)
        cellwalk_run_pytest(${test}_avx512_emulated ${words} CELLWALK_TWIN=_emulated CELLWALK_PROGRAM=${twin} LATE ${twin}
            NEEDS emulation LABELS long RESULT possible)
        if(possible)
            cellwalk_emulated_twin(${row_PROGRAM})
            add_dependencies(long ${row_PROGRAM}_emulated)
        endif()
    endif()
endfunction()

# A row for a function of package/test_package.py: NAME's or FUNCTION's, with name=value… as environment.
function(cellwalk_package_test name)
    cmake_parse_arguments(PARSE_ARGV 1 row "" "FUNCTION" "WITH;NEEDS")
    if(NOT row_FUNCTION)
        set(row_FUNCTION ${name})
    endif()
    cellwalk_run_pytest(${name} package test_package.py::test_${row_FUNCTION} ${row_UNPARSED_ARGUMENTS} NEEDS pytest ${row_NEEDS} ENVIRONMENT
        SOURCE=${PROJECT_SOURCE_DIR} CMAKE=${CMAKE_COMMAND} GENERATOR=${CMAKE_GENERATOR} CC=${CMAKE_C_COMPILER} ${row_WITH})
endfunction()
