"""The mutation operators of tools/mutate: each replaces a part of one line of C.

They work on tokens, outside comments, strings and directives other than #define. universalmutator 1.14.1 was tried first: it skips each
line on which a comment begins, among them 18 of 47 configured constants in a sample of 30 files; its rules change parts of names, so that
uint32_t becomes uint(32+1)_t, and 20 of 40 of its mutants did not compile. Of the first 307 mutants of these operators 2 did not compile.
"""
import collections
import re

Token = collections.namedtuple("Token", "text kind start end")
Change = collections.namedtuple("Change", "line operator original mutated")  # line from 1; the texts as plain() has them

TOKEN = re.compile(r"""
    (?P<comment> /\*.*?\*/ | //[^\n]* )
  | (?P<string> "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])*' )
  | (?P<number> 0[xX][0-9a-fA-F]+[uUlL]* | (?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?[fFuUlL]* )
  | (?P<name> [A-Za-z_]\w* )
  | (?P<mark> <<= | >>= | \.\.\. | -> | \+\+ | -- | << | >> | <= | >= | == | != | && | \|\| | [-+*/%&|^]= | [^\s\w] )
""", re.VERBOSE | re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
DEFINE = re.compile(r"[ \t]*\#[ \t]*define[ \t]+\w+(?:\([^)\n]*\))?")

RELATIONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)}
LOGIC = {"&&": ("||",), "||": ("&&",)}
ARITHMETIC = {"+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("*",), "+=": ("-=",), "-=": ("+=",), "*=": ("/=",),
              "/=": ("*=",), "++": ("--",), "--": ("++",)}
BITS = {"&": ("|",), "|": ("&",), "^": ("|",), "<<": (">>",), ">>": ("<<",), "&=": ("|=",), "|=": ("&=",), "^=": ("|=",),
        "<<=": (">>=",), ">>=": ("<<=",)}
NAMES = {"true": "false", "false": "true", "break": "continue", "continue": "break"}
MEMBERS = {one: other for pair in (("d", "q"), ("a", "b"), ("alpha", "beta"), ("sin", "cos"), ("min", "max"), ("largest", "smallest"))
           for one, other in (pair, pair[::-1])}
LIMITS = ("bounds_clamp", "bounds_magnitude", "fabsf", "fminf", "fmaxf")  # calls that are replaced by their first argument

KEYWORDS = set("auto case const default do else enum extern for goto if inline register return sizeof static struct switch typedef union "
               "volatile while _Static_assert static_assert".split())
TYPE = re.compile(r"^(?:\w+_t|float|double|bool|int|unsigned|char|void|long|short|signed)$")
DECLARED_ARRAY = re.compile(r"^\s*(?:(?:const|static|extern)\s+)*(?:struct\s+)?(?:\w+_t|float|bool|int|char|unsigned)\s+\**\w+\[")


def bare(text):
    """The source without its comments; each line keeps its number."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group()) if match.lastgroup == "comment" else match.group()
    return TOKEN.sub(blank, text)


def plain(line):
    """A line of source without indentation and alignment, by which a mutant is found in a later state of the tree."""
    return re.sub(r'"(?:\\.|[^"\\])*"|\s+', lambda match: match.group() if match.group()[0] == '"' else " ", line).strip()


def tokens_of(text):
    """Tokens of code and of the bodies of #define."""
    hidden, shown = [], []
    for match in DIRECTIVE.finditer(text):
        head = DEFINE.match(match.group())
        hidden.append((match.start(), match.start() + head.end() if head else match.end()))
        if head:
            shown.append((hidden[-1][1], match.end()))
    found = []
    for match in TOKEN.finditer(text):
        if not any(begin <= match.start() < end for begin, end in hidden):
            found.append(Token(match.group(), match.lastgroup, match.start(), match.end()))
    return found, shown


def number_changes(text):
    """The replacements of a number: one more and one less for a whole number; twice and half the value for another number; one for 0.0."""
    digits, suffix = re.fullmatch(r"(0[xX][0-9a-fA-F]+|[\d.]+(?:[eE][+-]?\d+)?)([fFuUlL]*)", text).groups()
    if re.fullmatch(r"0[xX].*", digits):
        return [f"{value:#x}{suffix}" for value in (int(digits, 16) + 1, int(digits, 16) - 1) if value >= 0]
    if digits.isdigit():
        return [f"{value}{suffix}" for value in (int(digits, 10) + 1, int(digits, 10) - 1) if value >= 0]
    value = float(digits)
    return [f"{number:.9g}" + ("" if re.search(r"[.e]", f"{number:.9g}") else ".0") + suffix
            for number in ((2.0 * value, 0.5 * value) if value else (1.0,))]


class Source:
    """The mutants of one file."""

    def __init__(self, text):
        self.text = bare(text)
        self.lines = self.text.split("\n")
        self.tokens, self.defined = tokens_of(self.text)
        self.begins = [0]
        for line in self.lines:
            self.begins.append(self.begins[-1] + len(line) + 1)
        self.bracketed, depth = [], 0
        for token in self.tokens:
            self.bracketed.append(depth > 0)
            depth += (token.text == "(") - (token.text == ")")
        self.found = []

    def changes(self):
        for n, token in enumerate(self.tokens):
            self.of_token(n, token)
            self.of_condition(n, token)
            self.of_limit(n, token)
            self.of_statement(n, token)
        unique = {(change.line, change.mutated): change for change in reversed(self.found)}
        return sorted(unique.values(), key=lambda change: (change.line, change.operator, change.mutated))

    def line_of(self, at):
        low, high = 0, len(self.begins) - 1
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.begins[middle] <= at else (low, middle)
        return low

    def add(self, operator, start, end, instead):
        line = self.line_of(start)
        if self.line_of(end - 1) == line:
            original, begin = self.lines[line], self.begins[line]
            mutated = original[:start - begin] + instead + original[end - begin:]
            self.found.append(Change(line + 1, operator, plain(original), plain(mutated)))

    def before(self, n):
        return self.tokens[n - 1] if n > 0 else Token("", "", 0, 0)

    def is_binary(self, n):
        before = self.before(n)
        if before.kind == "name":
            return before.text not in KEYWORDS and not TYPE.match(before.text)
        return before.kind == "number" or before.text in (")", "]")

    def of_token(self, n, token):
        before = self.before(n).text
        if token.kind == "mark":
            for operator, table in (("relation", RELATIONS), ("logic", LOGIC), ("arithmetic", ARITHMETIC), ("bits", BITS)):
                if token.text in table and (token.text not in "+-*&" or self.is_binary(n)):
                    for instead in table[token.text]:
                        self.add(operator, token.start, token.end, instead)
            if token.text in "-!~" and not self.is_binary(n):
                self.add("sign" if token.text == "-" else "negation", token.start, token.end, "")
        elif token.kind == "number":
            array = before == "[" and DECLARED_ARRAY.match(self.lines[self.line_of(token.start)])
            for instead in [] if array else number_changes(token.text):
                self.add("constant", token.start, token.end, instead)
        elif token.kind == "name" and token.text in NAMES:
            self.add("word", token.start, token.end, NAMES[token.text])
        elif token.kind == "name" and token.text in MEMBERS and before in (".", "->"):
            self.add("axis", token.start, token.end, MEMBERS[token.text])

    def closing(self, n):
        """Position of the closing bracket of bracket n, and of its first comma."""
        depth, comma = 0, None
        for m in range(n, len(self.tokens)):
            text = self.tokens[m].text
            depth += (text in ("(", "[", "{")) - (text in (")", "]", "}"))
            if depth == 0:
                return m, comma
            if depth == 1 and text == "," and comma is None:
                comma = m
        return None, None

    def of_condition(self, n, token):
        if token.text in ("if", "while") and n + 1 < len(self.tokens) and self.tokens[n + 1].text == "(":
            end, _ = self.closing(n + 1)
            if end is not None:
                start, stop = self.tokens[n + 1].start, self.tokens[end].end
                self.add("condition", start, stop, f"(!{self.text[start:stop]})")

    def of_limit(self, n, token):
        if token.text in LIMITS and n + 1 < len(self.tokens) and self.tokens[n + 1].text == "(" and not TYPE.match(self.before(n).text):
            end, comma = self.closing(n + 1)
            if end is not None:
                stop = self.tokens[comma if comma is not None else end].start
                self.add("limit", token.start, self.tokens[end].end, f"({self.text[self.tokens[n + 1].end:stop]})")

    def of_statement(self, n, token):
        """True for a statement, not a declaration, that begins and ends on this line."""
        if token.kind != "name" or self.before(n).text not in (";", "{", "}") or token.text in KEYWORDS or TYPE.match(token.text):
            return
        if self.bracketed[n] or any(begin <= token.start < end for begin, end in self.defined):
            return
        depth = 0
        for m in range(n, len(self.tokens)):
            text = self.tokens[m].text
            depth += (text in ("(", "[")) - (text in (")", "]"))
            if text in ("{", "}") or depth < 0:
                return
            if text == ";" and depth == 0:
                # Two consecutive names, or a name, a star and a name, are a declaration.
                second = self.tokens[n + 1]
                if second.kind != "name" and not (second.text == "*" and self.tokens[n + 2].kind == "name" and m == n + 3):
                    self.add("statement", token.start, self.tokens[m].end, ";")
                return


def changes_of(text):
    return Source(text).changes()


def occurrence_of(text, line):
    """How often the same line (from 1) occurs before it."""
    lines = [plain(each) for each in bare(text).split("\n")]
    return lines[:line - 1].count(lines[line - 1])


def applied(text, original, mutated, occurrence):
    """The source without comments, changed in this occurrence of the line, and the number of the line; (None, None) if there is no such line."""
    seen = 0
    lines = bare(text).split("\n")
    for n, line in enumerate(lines):
        if plain(line) == original:
            if seen == occurrence:
                return "\n".join(lines[:n] + [mutated] + lines[n + 1:]), n + 1
            seen += 1
    return None, None
