# docs/reference.md must equal the output of `lagless reference`.
execute_process(COMMAND ${LAGLESS} reference OUTPUT_FILE ${FRESH} RESULT_VARIABLE failed)
if(failed)
    message(FATAL_ERROR "lagless reference ended with ${failed}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${FRESH} ${REFERENCE} RESULT_VARIABLE differs)
if(differs)
    message(FATAL_ERROR "docs/reference.md is out of date: lagless reference >docs/reference.md")
endif()
