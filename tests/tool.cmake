# Tests of the program cellwalk, run as its users run it.
if(TARGET cellwalk_tool AND CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    foreach(name IN ITEMS tool_errors tool_info tool_trace)
        cellwalk_test(${name} ${name}.c program.c)
        target_link_libraries(test_${name} PRIVATE cellwalk_test_scratch cellwalk_test_rays)
        target_compile_definitions(test_${name} PRIVATE CELLWALK_PROGRAM="$<TARGET_FILE:cellwalk_tool>")
        add_dependencies(test_${name} cellwalk_tool)
    endforeach()
endif()
# The command lines of both programs.
if(TARGET cellwalk_tool AND CMOCKA_INCLUDE AND CMOCKA_LIBRARY)
    cellwalk_test(tool_options tool_options.c)
    target_link_libraries(test_tool_options PRIVATE cellwalk_test_scratch cellwalk_options)
    target_compile_definitions(test_tool_options PRIVATE
        OPTIONS_PROGRAMS="$<TARGET_FILE:cellwalk_tool>")
    add_dependencies(test_tool_options cellwalk_tool)
endif()
