"""The programs that judge a mutant, for tools/mutate: makes a private copy of the tree, builds it once, reads the objects and the run time of
each program, and links a program again with the objects that a mutant changes.
"""
import collections
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import threading

LABELS, NOT_LABELS = {"unit", "hal", "fixed", "rig"}, {"long", "grid", "board"}
COMPILE, LINK = 0.2, 0.1  # [s] of a processor, roughly; determines the order of the programs and the budget of a mutant
BUILT = ("firmware", "hal", "host_sim", "tests", "cmake", "CMakeLists.txt")
OPTIONS = ("-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_C_FLAGS_DEBUG=-O2", "-DCMAKE_CXX_FLAGS_DEBUG=-O2")  # objects without debug information
LARGEST_OUTPUT = 20000  # [blocks of 512 octets] of a program
ADDED = re.compile(r'^add_test\((?:\[=*\[)?([^\s\]]+)(?:\]=*\])?((?: "[^"]*")+)\)', re.MULTILINE)  # name, words
LINKED = re.compile(r"^(\S+\.a)\((\S+\.o)\)", re.MULTILINE)
FAILED = re.compile(r"^[^:\n]+:\d+:(\w+):FAIL", re.MULTILINE)

Done = collections.namedtuple("Done", "state text seconds")  # passed, failed, timeout


class Broken(Exception):
    """Raised if no verdict is possible: the tree does not build, or a test fails without a mutant."""


def ran(command, folder, log=None):
    """The output of a command; raises Broken if it fails."""
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if log is not None:
        log.write_text(done.stdout, encoding="utf-8")
    if done.returncode != 0:
        raise Broken(f"{shlex.join(str(word) for word in command)[:200]}: exit {done.returncode}\n{done.stdout[-3000:]}")
    return done.stdout


class Program:
    """A test program: its name, its objects, and its processor time [s]."""

    def __init__(self, name, command, build):
        self.name, self.command = name, command
        self.target = os.path.relpath(self.command[0], build)
        self.link, self.objects, self.sources, self.cost = [], set(), [], None


class Bench:
    """The tree that is mutated, and its build. `source`: the project; `folder`: gets all files that are written."""

    def __init__(self, source, folder, dearest, say):
        self.source, self.folder, self.dearest, self.say = source, folder, dearest, say
        self.tree, self.build = folder / "tree", folder / "build"
        self.judges_of = {}

    # ---- once ----

    def copy_tree(self):
        """Copies the present state of the files that git tracks, and returns their hash. Unchanged files keep their time stamp."""
        listed = ran(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], self.source).split("\0")
        names = sorted(name for name in listed if name and (self.source / name).is_file())
        sum_ = hashlib.sha256()
        for name in names:
            content = (self.source / name).read_bytes()
            if name.split("/")[0] in BUILT and name.endswith((".c", ".h", ".cpp", ".txt", ".cmake", ".toml")):
                sum_.update(name.encode() + b"\0" + content + b"\0")
            copied = self.tree / name
            if not copied.exists() or copied.read_bytes() != content:
                copied.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(self.source / name, copied)
        wanted = set(names)
        for path in [path for path in self.tree.rglob("*") if path.is_file()]:
            if path.relative_to(self.tree).as_posix() not in wanted:
                path.unlink()
        return sum_.hexdigest()[:16]

    def make(self, jobs):
        """Configures, builds the programs, and reads the objects of each program."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.hash = self.copy_tree()
        launcher = []
        if shutil.which("ccache"):
            launcher = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache", "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"]
        oracle = self.source / "build/host/tests/oracle/liblagless_oracle.a"
        if oracle.exists():
            launcher.append(f"-DLAGLESS_ORACLE={oracle}")  # saves almost a minute
        configure = ["cmake", "-S", str(self.tree), "-B", str(self.build), "-G", "Ninja", *OPTIONS, *launcher]
        made, as_made = self.folder / "made", " ".join([self.hash, *configure])
        is_made = made.exists() and made.read_text(encoding="utf-8") == as_made  # the programs of these files, linked by the same command
        if not is_made:
            made.unlink(missing_ok=True)
            ran(configure, self.folder, self.folder / "configure.log")
        listed = json.loads(ran(["ctest", "--show-only=json-v1"], self.build))
        commands = {}  # ctest lists them only for programs that are built
        for file in self.build.rglob("CTestTestfile.cmake"):
            for name, words in ADDED.findall(file.read_text(encoding="utf-8")):
                commands[name] = re.findall(r'"([^"]*)"', words)
        self.programs = []
        for test in listed["tests"]:
            labels = {label for each in test.get("properties", []) if each["name"] == "LABELS" for label in each["value"]}
            command = commands.get(test["name"], ["sh"])
            if labels & LABELS and not labels & NOT_LABELS and pathlib.Path(command[0]).is_relative_to(self.build):
                self.programs.append(Program(test["name"], command, self.build))
        if not self.programs:
            raise Broken("no test has the labels " + ", ".join(sorted(LABELS)))
        targets = sorted({program.target for program in self.programs})
        if not is_made:
            self.say(f"{len(self.programs)} programs are built")
            ran(["ninja", f"-j{jobs}", *targets], self.build, self.folder / "build.log")
            made.write_text(as_made, encoding="utf-8")
        self.read_graph(targets)
        self.measure(jobs)

    def read_graph(self, targets):
        self.compile = {}  # object -> words of its command
        self.made_of = {}  # object -> files of the tree that it is compiled of
        members = collections.defaultdict(list)
        for entry in json.loads((self.build / "compile_commands.json").read_text(encoding="utf-8")):
            words = [word for word in shlex.split(entry["command"]) if not word.endswith("ccache") and not word.startswith("-W")]
            made = words[words.index("-o") + 1]
            self.compile[made] = words
            room, _, inside = made.partition("CMakeFiles/")
            library = inside.split(".dir/")[0]
            members[f"{room}lib{library}.a", pathlib.PurePath(made).name].append(made)
        for block in re.split(r"\n\n+", ran(["ninja", "-t", "deps"], self.build)):
            head, *files = block.split("\n")
            paths = (pathlib.PurePath(os.path.normpath(self.build / name.strip())) for name in files)
            self.made_of[head.split(":")[0]] = {path.relative_to(self.tree).as_posix() for path in paths if path.is_relative_to(self.tree)}
        links = {}
        for line in ran(["ninja", "-t", "commands", *targets], self.build).splitlines():
            words = [word for part in line.split(" && ") for word in shlex.split(part) if part.strip() != ":"]
            if "-o" in words and "-c" not in words:
                links[words[words.index("-o") + 1]] = words
        for program in self.programs:
            program.link = links[program.target]
            own = [word for word in program.link if word.endswith(".o")]
            map_file = self.folder / "maps" / program.name
            if not map_file.exists() or map_file.stat().st_mtime < (self.build / program.target).stat().st_mtime:
                map_file.parent.mkdir(exist_ok=True)
                at = program.link.index("-o") + 1
                ran([*program.link[:at], self.folder / "linked", *program.link[at + 1:], f"-Wl,-Map={map_file}"], self.build)
            linked = LINKED.findall(map_file.read_text(encoding="utf-8").split("\nDiscarded input sections")[0])
            program.objects = set(own) | {made for key in linked for made in members[key]}
            program.sources = [file for made in own for file in self.made_of.get(made, ()) if file.endswith((".c", ".cpp"))]

    def measure(self, jobs):
        """The processor time of each program; a program above the largest permitted time does not judge mutants."""
        kept_file = self.folder / "costs.json"
        kept = json.loads(kept_file.read_text(encoding="utf-8")) if kept_file.exists() else {}
        costs = {}

        def one(program):
            digest = hashlib.sha256((self.build / program.target).read_bytes()).hexdigest()
            done = kept.get(f"{program.name} {digest}")
            if done is None:
                result = run(program.command, self.folder / "measured" / program.name, self.dearest)
                if result.state == "failed":
                    raise Broken(f"{program.name} fails without a mutant:\n{result.text[-2000:]}")
                done = [result.state, result.seconds]
            costs[f"{program.name} {digest}"] = done
            program.cost = done[1] if done[0] == "passed" and done[1] <= self.dearest else None

        in_threads(one, self.programs, jobs)
        kept_file.write_text(json.dumps(kept | costs), encoding="utf-8")
        dear = [program.name for program in self.programs if program.cost is None]
        self.programs = [program for program in self.programs if program.cost is not None]
        self.say(f"{len(self.programs)} programs judge, {sum(program.cost for program in self.programs):.0f} s of a processor altogether"
                 + (f"; longer than {self.dearest:g} s each and left out: {', '.join(dear)}" if dear else ""))

    # ---- of a file ----

    def reached(self, file):
        """Objects that the file is compiled into."""
        return {made for made, files in self.made_of.items() if file in files and made in self.compile}

    def judges(self, file, first=""):
        """Programs that contain an object of the file. The one named `first` comes first; the others follow in the order of the probability that
        they kill its mutants."""
        if file not in self.judges_of:
            self.judges_of[file] = self.ordered(file)
        return sorted(self.judges_of[file], key=lambda program: program.name != first)

    def ordered(self, file):
        """A key for sorting: first the programs with the name of the file, then by cost, of which programs that include its header get a
        quarter."""
        reached = self.reached(file)
        path = pathlib.PurePath(file)
        own = [header for header in (self.tree / path.parent).glob("*.h") if path.stem.startswith(header.stem)]
        names = [f'"{header.relative_to(self.tree / "firmware").as_posix()}"' for header in own if header.is_relative_to(self.tree / "firmware")]

        def key(program):
            named = program.name == path.stem or any(program.name == header.stem for header in own)
            includes = any(name in (self.tree / source).read_text(encoding="utf-8") for source in program.sources for name in names)
            return not named, (program.cost + LINK) * (0.25 if includes else 1.0), program.name

        return sorted((program for program in self.programs if program.objects & reached), key=key)


class Mutant:
    """A file of the tree with other text, in a separate folder."""

    def __init__(self, bench, folder, file, text):
        self.bench, self.folder, self.file = bench, folder, file
        shutil.rmtree(folder, ignore_errors=True)
        (folder / file).parent.mkdir(parents=True)
        (folder / file).write_text(text, encoding="utf-8")
        self.objects = {}  # object of the build -> object of the mutant

    def compile(self, made):
        """Compiles the object again; None if it does not compile."""
        if made not in self.objects:
            words = list(self.bench.compile[made])
            ours = self.folder / f"{len(self.objects)}.o"
            words[words.index("-o") + 1] = str(ours)
            source = os.path.relpath(words[words.index("-c") + 1], self.bench.tree)
            if source == self.file:
                words[words.index("-c") + 1] = str(self.folder / self.file)
            words[1:1] = ["-w", f"-I{self.folder / 'firmware'}", f"-I{self.folder}"]
            done = subprocess.run(words, cwd=self.bench.build, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
            self.objects[made] = ours if done.returncode == 0 else None
        return self.objects[made]

    def differs(self, programs):
        """True if an object of one of them changes; None if one does not compile."""
        linked = set().union(*(program.objects for program in programs)) if programs else set()
        for made in sorted(linked & self.bench.reached(self.file), key=lambda name: (self.file not in name, name)):
            ours = self.compile(made)
            if ours is None:
                return None
            if ours.read_bytes() != (self.bench.build / made).read_bytes():
                return True
        return False

    def cost(self, program):
        """[s] of a processor, about."""
        to_do = (program.objects & self.bench.reached(self.file)) - set(self.objects)
        return program.cost + LINK + COMPILE * len(to_do)

    def judged_by(self, program):
        """The result of the program, or None if the mutant does not compile."""
        ours = {made: self.compile(made) for made in sorted(program.objects & self.bench.reached(self.file))}
        if None in ours.values():
            return None
        words = [str(ours.pop(word)) if word in ours else word for word in program.link]
        linked = self.folder / "program"
        words[words.index("-o") + 1] = str(linked)
        first = next(n for n, word in enumerate(words) if word.endswith(".o"))
        # The object stands before the library, so that the linker does not take the object of the library.
        words[first:first] = [str(made) for made in ours.values()]
        ran(words, self.bench.build)
        return run([str(linked), *program.command[1:]], self.folder / "run", 5.0 * program.cost + 1.0)

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)


def run(command, folder, seconds):
    """Runs a program, with this limit of processor time [s]."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    limit = int(seconds) + 1
    limited = ["sh", "-c", f'ulimit -t {limit}; ulimit -f {LARGEST_OUTPUT}; ulimit -c 0; exec "$@"', "sh", *command]
    with open(folder / "printed", "wb") as printed:
        process = subprocess.Popen(limited, cwd=folder, stdin=subprocess.DEVNULL, stdout=printed, stderr=printed, start_new_session=True)
        late = threading.Timer(100.0 * limit, lambda: os.killpg(process.pid, signal.SIGKILL))
        late.start()
        _, status, usage = os.wait4(process.pid, 0)
        late.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
    text = (folder / "printed").read_text(encoding="utf-8", errors="replace")
    spent = usage.ru_utime + usage.ru_stime
    if process.returncode == 0:
        return Done("passed", text, spent)
    out_of_time = process.returncode in (-signal.SIGXCPU, -signal.SIGKILL)
    return Done("timeout" if out_of_time else "failed", text, spent)


def in_threads(work, items, jobs):
    """The results of the work for each item, in their order, `jobs` items at a time; the first exception ends the work."""
    waiting, lock, wrong = list(items)[::-1], threading.Lock(), []

    def worker():
        while True:
            with lock:
                if not waiting or wrong:
                    return
                item = waiting.pop()
            try:
                work(item)
            except BaseException as error:  # pylint: disable=broad-except
                wrong.append(error)

    threads = [threading.Thread(target=worker, daemon=True) for _ in range(jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if wrong:
        raise wrong[0]
