"""Estimates how many 16-bit words the code of a function takes on a C28x with FPU32, from the instructions of its code for a Cortex-M4F.
tools/cost and tools/check-linker use it.

Each instruction of the M4F (GCC, -O2) counts as the instructions that cl2000 writes for the same operation. Their sizes are those of
SPRU430 and SPRUEO2; the additional instructions were counted in listings of a motor drive that was built with cl2000 22.6.2 (EABI, fpu32,
5014 instructions, 519 float operations of two cycles):

    0.40 NOPs for each float operation, 0.20 in dense code, 0.83 between branches
    738 loads of an index register for 746 accesses that lie beyond the eight words of *+XARn[k]
    a MOVST0 for each compare of floats; branches of 16 bits' reach, B, two words, no SB
    a division or root is a call of the fast library, with its operands moved to R0H and R1H and back

Least and most are the limits of what differs between compilers: few or many NOPs, one index register for two accesses or one for each,
one-word or two-word integer instructions, choices by MINF32 and MAXF32 or by branches. Not included are spills (a C28x has 8 float
registers, an M4F 32; in those listings 3 % of the accesses went to the stack), and differences in the inlining of both compilers. The
dense parts of the listings take 1.44 to 1.55 words per instruction. The accuracy of the likely number is about +-15 %.
"""
import pathlib
import re
import subprocess

REACH = 7  # [words] *+XARn[k]
STACK_REACH = 63  # [words] *-SP[k]

FLOAT = (2.2, 2.4, 2.83)  # with its NOPs
NEAR_FLOAT, FAR_FLOAT = (2, 2, 2), (2.5, 3, 3)  # MOV32; with MOVB AR0
NEAR, FAR, INDEXED = (1, 1, 2), (1.5, 2, 3), (3, 4, 5)  # MOVL
SHORT, LONG = (2, 2, 2), (4, 4, 4)  # MOVIZ; MOVIZ and MOVXI
INTEGER = (1, 1.4, 2)
SIZES = (  # the first row that fits the mnemonic is used
    (r"v(div|sqrt)", (4, 6, 8)),
    (r"v(n?mul|n?ml[as]|fn?m[as]|add|sub)", FLOAT),
    (r"vcmp", (2, 2, 2)),
    (r"vmrs", (1, 1, 1)),
    (r"v(cvt|rint)", (2, 2.4, 4)),
    (r"v(mov|abs|neg|sel)", (2, 2, 2)),
    (r"[su]div", (4, 6, 10)),
    (r"[su]mull", (3, 4, 6)),
    (r"[su]mlal", (5, 6, 8)),
    (r"(mul|mla|mls)s?", (2, 3, 4)),
    (r"it[te]*", (0, 1, 2)),
    (r"tb[bh]", (6, 8, 10)),
    (r"cbn?z", (2, 3, 3)),
    (r"blx?", (2, 2, 2)),
    (r"bx", (1, 1, 1)),
    (r"b(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|al)?", (1, 2, 2)),
    (r"nop", (0, 0, 0)),
)


def times(count, size):
    return tuple(count * words for words in size)


def registers(operands):
    """Number of registers in a list such as {r4-r7, lr}."""
    count = 0
    for part in operands[operands.index("{") + 1:operands.index("}")].split(","):
        ends = [int(end) for end in re.findall(r"\d+", part)] if "-" in part else []
        count += ends[1] - ends[0] + 1 if ends else 1
    return count


def access(mnemonic, operands):
    """Size of a load or store."""
    is_float = mnemonic.startswith("v")
    if "{" in operands:
        return times(registers(operands), NEAR_FLOAT if is_float else (1, 1, 1))
    count = 2 if re.match(r"(ldr|str)d|v(ldr|str)(\.64)", mnemonic) else 1
    address = re.search(r"\[(\w+)(?:, ([^\]]+))?\]", operands)
    base, offset = address.groups() if address else ("", None)
    if offset and not offset.startswith("#"):
        return times(count, INDEXED)
    octets = int(offset[1:], 0) if offset else 0
    near = 0 <= octets // 2 <= (STACK_REACH if base == "sp" else REACH)
    return times(count, (NEAR_FLOAT if near else FAR_FLOAT) if is_float else NEAR if near else FAR)


def words_of(mnemonic, operands, literal):
    """Least, likely, most; `literal`: the constant that a load relative to the program counter fetches."""
    base = mnemonic.split(".")[0]
    if re.match(r"v?(push|pop|ldm|stm|ldr|str)", base):
        if literal is not None:
            long = literal & 0xFFFF if base.startswith("v") else literal >> 22
            return LONG if long else SHORT
        return access(mnemonic, operands)
    for pattern, size in SIZES:
        if re.fullmatch(pattern, base):
            if base == "vmov" and re.search(r"\br\d|\b(ip|lr)\b", operands):
                return (2, 4, 6)  # MOV32 between CPU and FPU, and cycles of alignment
            return size
    return INTEGER


FUNCTION = re.compile(r"^[0-9a-f]+ <([\w.]+)>:$")
LINE = re.compile(r"^ *([0-9a-f]+):\t(?:[0-9a-f]{4} ?)+\s*\t([a-z][\w.]*)\s*([^;@]*)")
POOL = re.compile(r"^ *([0-9a-f]+):\t([0-9a-f]{8}) +\t\.word")


def of_listing(text):
    """Function -> its words (least, likely, most), from the output of objdump -d for an object. A copy that the compiler has made of a
    function for some of its calls counts with it."""
    functions, now, pool, found = [], None, {}, {}
    for line in text.splitlines():
        head, code, word = FUNCTION.match(line), LINE.match(line), POOL.match(line)
        if head:
            now, pool = [], {}
            functions.append((head[1].split(".")[0], now, pool))
        elif word and now is not None:
            pool[int(word[1], 16)] = int(word[2], 16)
        elif code and now is not None:
            now.append((int(code[1], 16), code[2], code[3].strip()))
    for name, listing, pool in functions:
        total = (0, 0, 0)
        for address, mnemonic, operands in listing:
            relative = re.search(r"\[pc(?:, #(-?\w+))?\]", operands)
            place = (address + 4 & ~3) + int(relative[1] or "0", 0) if relative else None
            size = words_of(mnemonic, operands, pool.get(place, 0) if relative else None)
            total = tuple(a + b for a, b in zip(total, size))
        found[name] = tuple(a + b for a, b in zip(found.get(name, (0, 0, 0)), total))
    return found


def of_object(path, objdump="arm-none-eabi-objdump"):
    return of_listing(subprocess.run([objdump, "-d", str(path)], stdout=subprocess.PIPE, text=True, check=True).stdout)


STAND_IN = ("-D__TMS320C2000__", "-D__cregister=", "-D__interrupt=", "-D__asm(text)=((void)0)")  # as in tools/check-linker


def compiled(path, options, folder, compiler="arm-none-eabi-gcc"):
    """Compiles a source that the build for the M4F does not have, and returns the object."""
    made = pathlib.Path(folder, f"{path.stem}.o")
    header = str(pathlib.Path(__file__).resolve().parent / "include/c28x.h")
    subprocess.run([compiler, "-std=c99", "-O2", "-c", "-w", "-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard",
                    "-ffp-contract=off", "-fno-tree-slp-vectorize", "-include", header, *STAND_IN, *options, str(path), "-o", str(made)],
                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=True)
    return made


def of_source(path, options, folder, compiler="arm-none-eabi-gcc"):
    """The words of the functions of a source that the build for the M4F does not have, and that is compiled here."""
    return of_object(compiled(path, options, folder, compiler), compiler.removesuffix("gcc") + "objdump")


def functions_in_ram(command_file):
    """Names of the functions that the linker command file collects for RAM."""
    return set(re.findall(r"\*\(\.text:(\w+)\)", command_file.read_text(encoding="utf-8")))


def together(sizes):
    return tuple(round(sum(size[n] for size in sizes)) for n in range(3))
