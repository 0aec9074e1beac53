#!/usr/bin/env python3
"""Proves tools/check-dialect. A small tree in the C dialect of the F28335 passes. Each fault that is planted in it is found, and the
message names file, line, rule and remedy. Ends with 77 where clang, readelf or cppcheck is missing."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-B", str(PROJECT / "tools/check-dialect")]
TOOLS = ("clang", "readelf", "cppcheck")
CPPCHECK = subprocess.run(["cppcheck", "--version"], stdout=subprocess.PIPE, text=True, check=False).stdout.strip() \
    if shutil.which("cppcheck") else ""

TREE = {
    "firmware/math/angle.h": (
        "#include <stdint.h>\n"
        "float angle_wrap(float x);\n"
        "int32_t angle_turns(int16_t a, int16_t b);\n"
        "const char *angle_name(uint16_t n);\n"
        "float angle_long(float x);\n"
    ),
    "firmware/math/angle.c": (
        '#include "math/angle.h"\n'
        "#include <string.h>\n"
        "static uint32_t bits_of(float x)\n"
        "{\n"
        "#if defined(__TMS320C2000__)\n"
        "    return __f32_bits_as_u32(x);\n"
        "#else\n"
        "    uint32_t bits;\n"
        "    memcpy(&bits, &x, sizeof bits);\n"
        "    return bits;\n"
        "#endif\n"
        "}\n"
        "float angle_wrap(float x)\n"
        "{\n"
        "    return (bits_of(x) >> 31) != 0u ? -x : x * 2.0f;\n"
        "}\n"
        "int32_t angle_turns(int16_t a, int16_t b)\n"
        "{\n"
        "    return (int32_t)a * b + ((a > 0) - (a < 0));\n"
        "}\n"
        "const char *angle_name(uint16_t n)\n"
        "{\n"
        '    static const char *const names[] = {"double", "uint8_t 1.0"};\n'
        '    return n < sizeof names / sizeof names[0] ? names[n] : "";\n'
        "}\n"
        "typedef struct { size_t offset; } row_t;\n"
        "size_t angle_slot(const row_t *row);\n"
        "size_t angle_slot(const row_t *row)\n"
        "{\n"
        "    return row->offset / sizeof(uint32_t);\n"
        "}\n"
        # The function is so long that the compiler jumps over it by an address; this jump is not a recursive call.
        "float angle_long(float x)\n"
        "{\n"
        "    float sum = x;\n"
        "    if (x > 0.0f) {\n" + "        sum += 0.1f;\n" * 100 +
        "    }\n"
        "    return sum;\n"
        "}\n"
    ),
    "firmware/drive/drive.h": "void drive_init(float *state);\nfloat drive_step(float x);\n",
    "firmware/drive/drive.c": (
        '#include "drive/drive.h"\n'
        "#include <math.h>\n"
        '#include "math/angle.h"\n'
        "void drive_init(float *state)\n"
        "{\n"
        "    *state = sinf(1.0f);\n"
        "}\n"
        "float drive_step(float x)\n"
        "{\n"
        "    return fabsf(angle_wrap(x));\n"
        "}\n"
    ),
    "firmware/app/app.h": '#include "hal/hal.h"\nHAL_INTERRUPT void app_interrupt(void);\n',
    "firmware/app/app.c": (
        '#include "app/app.h"\n'
        '#include "drive/drive.h"\n'
        "static float state;\n"
        "HAL_INTERRUPT void app_interrupt(void)\n"
        "{\n"
        "    hal_write((uint16_t)drive_step(state));\n"
        "}\n"
    ),
    "hal/hal.h": (
        "#include <stdint.h>\n"
        "#if defined(__TMS320C2000__)\n"
        "#define HAL_INTERRUPT __interrupt\n"
        "#define bus_write16(address, value) (*(volatile uint16_t *)(address) = (value))\n"
        "#else\n"
        "#define HAL_INTERRUPT\n"
        "void bus_write16(uint16_t address, uint16_t value);\n"
        "#endif\n"
        "void hal_write(uint16_t count);\n"
    ),
    "hal/f28335/pwm.c": (
        '#include "hal/hal.h"\n'
        "void hal_write(uint16_t count)\n"
        "{\n"
        "    bus_write16(0x6809u, count);\n"
        "}\n"
    ),
}
MISRA = """\
2.5   hal/hal.h                 bus_write16      a small tree
8.9   firmware/app/app.c        state            a small tree
10.4  firmware/math/angle.c     \\(a > 0\\)        a sign
11.4  hal/f28335/pwm.c          bus_write16      registers are at fixed addresses
12.1  firmware/math/angle.c     any              school algebra
17.7  *                         memcpy           returns its first argument
"""

# What is planted: name of the fault, source, code, the line of it that the message must name, rule, texts of the message.
TYPES = (
    ("product of constants over 16 bits", "firmware/math/angle.c",
     "extern const int32_t period;\nconst int32_t period = 300 * 300;\n",
     2, "compiler", "integer-overflow", "INT32_C()"),
    ("product of two in 16 bits", "hal/f28335/pwm.c",
     "int more(uint16_t a, uint16_t b);\nint more(uint16_t a, uint16_t b)\n{\n    return a * b > 40000u;\n}\n",
     4, "product", "16 bits times 16 bits", "cast the first operand"),
    ("product made wide by a cast of the whole", "firmware/math/angle.c",
     "float square(uint16_t a);\nfloat square(uint16_t a)\n{\n    return (float)(a * a);\n}\n",
     4, "width", "`*` in unsigned int", "becomes float too late"),
    ("shift made wide too late", "hal/f28335/pwm.c",
     "uint32_t bit(uint16_t n);\nuint32_t bit(uint16_t n)\n{\n    return 1u << n;\n}\n",
     4, "width", "`<<` in unsigned int", "cast its first operand"),
    ("shift beyond an int", "hal/f28335/pwm.c",
     "extern const uint32_t high;\nconst uint32_t high = 1u << 16;\n",
     2, "compiler", "shift-count-overflow", "UINT32_C()"),
    ("number too wide for its type", "hal/f28335/pwm.c",
     "int16_t low(int32_t x);\nint16_t low(int32_t x)\n{\n    return x;\n}\n",
     4, "compiler", "onversion", "a cast if the value fits"),
    ("double literal", "firmware/drive/drive.c",
     "float half(void);\nfloat half(void)\n{\n    return (float)0.5;\n}\n",
     4, "double", "literal 0.5", "put an f after it"),
    ("double behind a macro", "firmware/drive/drive.c",
     "#define PRECISE double\nextern const PRECISE one;\n",
     2, "double", "`one`", "float"),
    ("float promoted to double", "firmware/drive/drive.c",
     "int text(int n, ...);\nint put(float x);\nint put(float x)\n{\n    return text(1, x);\n}\n",
     5, "double", "becomes a double", "float operands"),
    ("type of 8 bits", "hal/f28335/pwm.c",
     "extern const uint8_t octet;\n",
     1, "compiler", "'uint8_t'", "uint16_t, with & 0xFFu"),
    ("char as a number", "hal/f28335/pwm.c",
     "struct frame {\n    unsigned char length;\n};\n",
     2, "octet", "`length`", "uint16_t, with & 0xFFu"),
    ("arithmetic on a text", "hal/f28335/pwm.c",
     "int digit(const char *text);\nint digit(const char *text)\n{\n    return *text - '0';\n}\n",
     4, "octet", "`-` on a char", "& 0xFFu"),
    ("size taken for octets", "firmware/math/angle.c",
     "uint16_t bits(void);\nuint16_t bits(void)\n{\n    return (uint16_t)(8u * sizeof(uint32_t));\n}\n",
     4, "sizeof", "counts chars", "count elements"),
    ("address kept in 16 bits", "hal/f28335/pwm.c",
     "extern const uint16_t load_size[];\nuint16_t words(void);\nuint16_t words(void)\n{\n"
     "    return (uint16_t)load_size;\n}\n",
     5, "address", "becomes unsigned int", "22 bits", "uint32_t"),
    ("address made of 16 bits", "hal/f28335/pwm.c",
     "uint16_t look(uint16_t at);\nuint16_t look(uint16_t at)\n{\n    return *(const uint16_t *)at;\n}\n",
     4, "address", "out of unsigned int", "uint32_t"),
    ("difference of pointers kept in 16 bits", "firmware/math/angle.c",
     "int32_t room(const float *a, const float *b);\nint32_t room(const float *a, const float *b)\n{\n"
     "    const int16_t n = (b - a) + 1;\n    return (int32_t)n;\n}\n",
     4, "address", "has 32 bits", "ptrdiff_t"),
    ("array of variable length", "firmware/math/angle.c",
     "float sum(int n);\nfloat sum(int n)\n{\n    float x[n];\n    x[0] = 1.0f;\n    return x[0];\n}\n",
     4, "compiler", "-Wvla", "constant length"),
    ("address in the core", "firmware/math/angle.c",
     "uint16_t peek(void);\nuint16_t peek(void)\n{\n    return *(uint16_t *)0x7108u;\n}\n",
     4, "register", "only hal/ accesses registers", "hal.h"),
    ("volatile data in the core", "firmware/math/angle.c",
     "extern volatile const uint16_t result;\n",
     1, "register", "`result` is volatile", "pass its value in"),
    ("assembler in the core", "firmware/math/angle.c",
     "void stop(void);\nvoid stop(void)\n{\n    __asm(\" ESTOP0\");\n}\n",
     4, "register", "assembler", "hal.h"),
)
INTERRUPT = "HAL_INTERRUPT void {0}(void);\nHAL_INTERRUPT void {0}(void)\n{{\n    {1};\n}}\n"
CALLS = (
    ("libm", "hal/f28335/pwm.c", "#include <math.h>\n" + INTERRUPT.format("wave", "hal_write((uint16_t)sinf(1.0f))"),
     5, "interrupt", "sinf of the C library in wave", "firmware/math"),
    ("libm in the layers below", "firmware/app/app.c", INTERRUPT.format("late_init", "drive_init(&state)"),
     None, "interrupt", "sinf of the C library in late_init -> drive_init", "compute the value in x_init"),
    ("check", "hal/f28335/pwm.c",
     "void check_failed(const char *function, uint16_t line);\n" + INTERRUPT.format("doubt", 'check_failed("", 1u)'),
     5, "interrupt", "check_failed of the C library in doubt", "use CHECK in x_init"),
    ("copy by the library", "hal/f28335/pwm.c",
     "#include <string.h>\nextern float to, from;\n" + INTERRUPT.format("copy", "memcpy(&to, &from, sizeof to)"),
     6, "interrupt", "memcpy of the C library in copy", "math/float_bits.h"),
    ("memory cleared by the library", "hal/f28335/pwm.c",
     INTERRUPT.format("clear", "memset(&to, 0, sizeof to)"),
     4, "interrupt", "memset of the C library in clear", "assign the struct"),
    ("call through a pointer", "hal/f28335/pwm.c",
     "extern void (*const hook)(void);\n" + INTERRUPT.format("hooked", "hook()"),
     5, "interrupt", "through a pointer in hooked", "a switch"),
    ("recursion", "firmware/math/angle.c",
     "int down(int n);\nint even(int n);\nint down(int n)\n{\n    return n > 0 ? even(n - 1) : 0;\n}\n"
     "int even(int n)\n{\n    return down(n);\n}\n",
     3, "recursion", "down -> even -> down", "a loop"),
    ("global in the core", "firmware/drive/drive.c", "extern float last;\nfloat last;\n",
     2, "data", "`last` is writable data of the core", "its caller owns"),
    ("static in a function of the core", "firmware/drive/drive.c",
     "int count(void);\nint count(void)\n{\n    static int n = 3;\n    return n++;\n}\n",
     4, "data", "writable data of the core", "its caller owns"),
)


class CheckDialect(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="lagless_dialect_test_"))
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in TREE.items():
            self.write(name, text)
        shutil.copytree(PROJECT / "tools/target", self.root / "tools/target")
        self.write("tools/target/misra.txt", MISRA)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def append(self, name, text):
        """Appends the text; returns the number of lines that the file had before."""
        before = (self.root / name).read_text()
        self.write(name, before + text)
        return before.count("\n")

    def check(self, *gates):
        return subprocess.run([*COMMAND, "--root", str(self.root), *gates], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=False)

    def assert_each_is_found(self, gate, faults):
        """All faults are planted in one tree, since starting the tools takes longer than checking. Each fault is reported at its line, and
        no line without a fault is reported."""
        wanted = []
        for name, source, code, line, rule, *texts in faults:
            before = self.append(source, code)
            where = "firmware/drive/drive.c:6" if line is None else f"{source}:{before + line}"
            wanted.append((name, where, rule, texts))
        run = self.check(gate)
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        rows = [row for row in run.stdout.splitlines() if row.startswith(("firmware/", "hal/", "tools/"))]
        for name, where, rule, texts in wanted:
            with self.subTest(name):
                found = [row for row in rows if row.startswith(f"{where}: {rule}: ")]
                self.assertEqual(len(found), 1, "\n".join(rows))
                for text in texts:
                    self.assertIn(text, found[0])
        blamed = {":".join(row.split(":")[:2]) for row in rows}
        self.assertEqual(blamed, {where for _, where, _, _ in wanted}, run.stdout)

    def test_good_tree_passes(self):
        run = self.check()
        self.assertEqual((run.returncode, run.stderr), (0, ""), run.stdout)
        self.assertIn("4 sources of firmware and hal pass types, calls, misra", run.stdout)
        self.assertIn("app_interrupt  firmware/app/app.c\n    drive_step  firmware/drive/drive.c\n"
                      "        angle_wrap  firmware/math/angle.c\n            bits_of  firmware/math/angle.c\n"
                      "    hal_write  hal/f28335/pwm.c\n", run.stdout)

    def test_each_fault_of_types_is_found(self):
        self.assert_each_is_found("types", TYPES)

    def test_each_fault_of_calls_is_found(self):
        self.assert_each_is_found("calls", CALLS)

    def test_addresses_in_32_bits_are_good(self):
        self.append("hal/f28335/pwm.c",
                    "#include <stddef.h>\n"
                    "extern const uint16_t load_size[];\n"
                    "uint32_t words(void);\n"
                    "uint32_t words(void)\n{\n    return (uint32_t)load_size + (uint32_t)hal_write;\n}\n"
                    "uint32_t span(const float *a, const float *b);\n"
                    "uint32_t span(const float *a, const float *b)\n{\n"
                    "    const ptrdiff_t n = b - a;\n"
                    "    const int16_t low = (int16_t)(b - a);\n"
                    "    return b - a > 3 ? (uint32_t)n : (uint32_t)(b - a) + (uint32_t)a[b - a] + (uint32_t)low;\n}\n"
                    "const uint16_t *at(uint32_t address);\n"
                    "const uint16_t *at(uint32_t address)\n{\n    return (const uint16_t *)address;\n}\n")
        run = self.check("types")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_a_struct_may_be_copied_in_the_interrupt(self):
        self.append("hal/f28335/pwm.c", "typedef struct {\n    float x[40];\n} many_t;\nextern many_t to, from;\n" +
                    INTERRUPT.format("copy", "to = from"))
        run = self.check("calls")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_source_that_does_not_compile_has_no_calls(self):
        before = self.append("hal/f28335/pwm.c", "extern const uint8_t octet;\n")
        run = self.check("calls")
        self.assertEqual(run.returncode, 1)
        self.assertIn(f"hal/f28335/pwm.c:{before + 1}: compiler: unknown type name 'uint8_t'", run.stdout)

    def test_no_interrupt_is_an_error(self):
        for name in ("firmware/app/app.c", "firmware/app/app.h"):
            self.write(name, TREE[name].replace("HAL_INTERRUPT ", ""))
        run = self.check("calls")
        self.assertEqual(run.returncode, 2)
        self.assertIn("HAL_INTERRUPT", run.stderr)

    @unittest.skipUnless("Cppcheck 2.10" in CPPCHECK, f"MISRA is judged by cppcheck 2.10, not {CPPCHECK}")
    def test_faults_that_cppcheck_sees(self):
        before = self.append("hal/f28335/pwm.c", "int f(int x);\nint f(int x)\n{\n    const int a[2] = {1, 2};\n"
                                                 "    if (x)\n        return a[2];\n    return 0;\n}\n")
        self.append("tools/target/misra.txt", "15.5  *      any  refused at the top\n"
                                              "20.5  hal/*  any  there was an #undef once\n")
        run = self.check("misra")
        self.assertEqual(run.returncode, 1)
        rows = [row for row in run.stdout.splitlines() if not row.startswith(("rule", "MISRA"))]
        self.assertEqual(len(rows), 3, run.stdout)
        self.assertEqual(rows[0], f"hal/f28335/pwm.c:{before + 5}: misra: rule 14.4 in `if (x)`; correct it, or justify "
                                  "it in tools/target/misra.txt")
        self.assertTrue(rows[1].startswith(f"hal/f28335/pwm.c:{before + 6}: cppcheck: arrayIndexOutOfBounds"), rows[1])
        self.assertEqual(rows[2], "tools/target/misra.txt:8: misra: rule 20.5 is justified for hal/*, where cppcheck has "
                                  "no such finding; remove the row")

    @unittest.skipUnless("Cppcheck 2.10" in CPPCHECK, f"MISRA is judged by cppcheck 2.10, not {CPPCHECK}")
    def test_cppcheck_uses_the_sizes_of_the_eabi(self):
        outside = set()
        for what, words in (("char", 1), ("int", 1), ("long", 2), ("void *", 2), ("double", 4), ("L'a'", 2)):
            for length in (words, words + 1):
                before = self.append("hal/f28335/pwm.c", f"int last(void)\n{{\n    static const int a[{length}] = {{0}};\n"
                                                         f"    return a[sizeof({what})];\n}}\n")
                if length == words:
                    outside.add(f"hal/f28335/pwm.c:{before + 4}")
        rows = [row.partition(": cppcheck: arrayIndexOutOfBounds") for row in self.check("misra").stdout.splitlines()]
        self.assertEqual({place for place, found, _ in rows if found}, outside)

    def test_justification_without_a_reason_is_an_error(self):
        self.append("tools/target/misra.txt", "20.5  hal/*  any\n")
        run = self.check("misra")
        self.assertEqual(run.returncode, 2)
        self.assertIn("misra.txt:7: expected `rule  file  what  reason`", run.stderr)

    def test_unknown_gate_is_an_error(self):
        run = self.check("style")
        self.assertEqual(run.returncode, 2)
        self.assertIn("no check 'style': accepted: types, calls, misra", run.stderr)

    def test_empty_tree_is_an_error(self):
        shutil.rmtree(self.root / "firmware")
        shutil.rmtree(self.root / "hal")
        self.assertEqual(self.check().returncode, 2)


if __name__ == "__main__":
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        print(f"not checked: this machine has no {', '.join(missing)}")
        sys.exit(77)
    unittest.main()
