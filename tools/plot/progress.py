"""Reports the progress of a drawing to the program that started it: `lagless` shows it on a terminal. Without such a program
nothing is reported."""
import os
import sys

ASKED = "LAGLESS_PROGRESS"
BAR = 60  # [columns] width of the bar


def tell(fraction):
    """Reports the completed share, 0 to 1."""
    descriptor = os.environ.get(ASKED, "")
    if descriptor.isdigit():
        try:
            os.write(int(descriptor), f"{fraction:.4f}\n".encode())
        except OSError:
            pass  # the program that started the drawing has ended


def part(begin, end):
    """Returns a function that reports the progress of a part of the work, 0 to 1; the part covers begin to end of the whole."""
    return lambda fraction: tell(begin + (end - begin) * fraction)


def clear():
    """Ends the line of the bar, so that the next output begins in a new line."""
    if ASKED in os.environ and sys.stderr.isatty():
        print(f"\r{'':{BAR}}\r", end="", file=sys.stderr, flush=True)


def end():
    """Ends the reports."""
    clear()
    descriptor = os.environ.pop(ASKED, "")
    if descriptor.isdigit():
        try:
            os.close(int(descriptor))
        except OSError:
            pass  # the program that started the drawing has ended
