# This is the path of the interpreter itself, because the `python3` of a version manager is a script that takes longer to start than
# many Python programs of this project run, and a check starts it several hundred times. If this interpreter is too old, find_package
# searches for another one.
if(NOT Python3_EXECUTABLE)
    execute_process(COMMAND python3 -c "import sys; print(sys.executable if sys.version_info >= (3, 9) else '')"
        OUTPUT_VARIABLE interpreter OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(interpreter AND EXISTS "${interpreter}")
        set(Python3_EXECUTABLE "${interpreter}" CACHE FILEPATH "The Python interpreter for tests, pictures and tools")
    endif()
endif()
find_package(Python3 3.9 COMPONENTS Interpreter QUIET)
