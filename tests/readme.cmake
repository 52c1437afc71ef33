# The example of the README compiles, prints what the README says, and is the one that the README shows.
add_executable(readme_example readme_example.c)
target_link_libraries(readme_example PRIVATE cellwalk::cellwalk_static cellwalk_flags)
add_test(NAME readme_example COMMAND readme_example)
set_tests_properties(readme_example PROPERTIES PASS_REGULAR_EXPRESSION
    "t = 1\\.58333 in cell \\(0, 1\\), at \\(0\\.583333, 1\\.25, 2\\)")
add_test(NAME readme_text COMMAND ${CMAKE_COMMAND} -D README=${PROJECT_SOURCE_DIR}/README.md
    -D SOURCE=${CMAKE_CURRENT_SOURCE_DIR}/readme_example.c -P ${CMAKE_CURRENT_SOURCE_DIR}/readme_text.cmake)
