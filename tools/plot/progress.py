"""How far a drawing has come, for who started it: `lagless` shows it on a terminal. Nobody asked: nothing."""
import os


def tell(fraction):
    """So much of it is done, 0 to 1."""
    descriptor = os.environ.get("LAGLESS_PROGRESS", "")
    if descriptor.isdigit():
        try:
            os.write(int(descriptor), f"{fraction:.4f}\n".encode())
        except OSError:
            pass  # who asked is gone
