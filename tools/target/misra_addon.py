"""Runs the unchanged MISRA addon of cppcheck in half the time: it is imported, so that Python stores the compiled form, and the
garbage collection is off. cppcheck starts Python for each source; tools/check-dialect passes this file to cppcheck, whose
runaddon.py adds the folder of misra.py to the path."""
import gc

gc.disable()
import misra  # noqa: E402

misra.main()
