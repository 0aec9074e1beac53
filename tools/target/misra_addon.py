"""cppcheck's addon for MISRA as it is, in half the time: imported, so that Python keeps it compiled, and without collecting garbage.
cppcheck starts Python for each source; check-dialect gives it this file, its runaddon.py puts the folder of misra.py on the path."""
import gc

gc.disable()
import misra  # noqa: E402

misra.main()
