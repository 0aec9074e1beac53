# The path of the interpreter itself: the `python3` of a version manager is a script that takes longer to start than many of our Python
# programs run, and a check starts it some hundred times. If this interpreter is too old, find_package searches for another one.
if(NOT Python3_EXECUTABLE)
    execute_process(COMMAND python3 -c "import sys; print(sys.executable if sys.version_info >= (3, 9) else '')"
        OUTPUT_VARIABLE interpreter OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(interpreter AND EXISTS "${interpreter}")
        set(Python3_EXECUTABLE "${interpreter}" CACHE FILEPATH "The Python that tests, pictures and tools run with")
    endif()
endif()
find_package(Python3 3.9 COMPONENTS Interpreter QUIET)
