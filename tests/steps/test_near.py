"""The tests that tools/near selects for a change, in a small project of two libraries. usage: test_near.py"""

import pathlib
import shutil
import subprocess
import tempfile
import unittest

NEAR = pathlib.Path(__file__).resolve().parents[2] / "tools/near"
FILES = {
    "CMakeLists.txt": """cmake_minimum_required(VERSION 3.21)
project(small LANGUAGES C)
enable_testing()
add_library(parts STATIC a.c b.c)
add_executable(test_a test_a.c)
add_executable(test_b test_b.c)
target_link_libraries(test_a parts)
target_link_libraries(test_b parts)
add_test(NAME a COMMAND test_a)
add_test(NAME b COMMAND test_b)
add_test(NAME layers COMMAND true)
set_tests_properties(layers PROPERTIES LABELS layers)
add_subdirectory(tests)
""",
    "tests/CMakeLists.txt": "add_test(NAME script COMMAND true)\n",
    "CMakePresets.json": """{"version": 3,
 "configurePresets": [{"name": "host", "generator": "Ninja", "binaryDir": "${sourceDir}/build/host"}],
 "testPresets": [{"name": "host", "configurePreset": "host"}]}
""",
    ".gitignore": "build\n",
    "a.h": "int a(void);\n",
    "a.c": '#include "a.h"\nint a(void) { return 0; }\n',
    "b.c": "int b(void);\nint b(void) { return 0; }\n",
    "test_a.c": '#include "a.h"\nint main(void) { return a(); }\n',
    "test_b.c": "int b(void);\nint main(void) { return b(); }\n",
}


class Near(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory(prefix="lagless_near_")
        cls.root = pathlib.Path(cls.made.name)
        for name, text in FILES.items():
            (cls.root / name).parent.mkdir(exist_ok=True)
            (cls.root / name).write_text(text)
        (cls.root / "tools").mkdir()
        shutil.copy(NEAR, cls.root / "tools")
        for command in ("git init -q .", "git add -A", "git -c user.name=t -c user.email=t@t commit -qm all", "cmake --preset host",
                        "cmake --build build/host"):
            subprocess.run(command.split(), cwd=cls.root, check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.made.cleanup()

    def tearDown(self):
        subprocess.run(["git", "checkout", "-q", "."], cwd=self.root, check=True)

    def near(self, *arguments):
        return subprocess.run(["tools/near", *arguments], cwd=self.root, capture_output=True, text=True, check=False)

    def chosen_after_change_of(self, *names):
        for name in names:
            (self.root / name).write_text((self.root / name).read_text() + "\n")
        done = self.near("--list")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        return set(done.stdout.splitlines()[1:])

    def test_a_source_reaches_the_programs_that_contain_its_functions(self):
        self.assertEqual({"a", "layers"}, self.chosen_after_change_of("a.c"))

    def test_the_source_of_a_test_reaches_that_test(self):
        self.assertEqual({"b", "layers"}, self.chosen_after_change_of("test_b.c"))

    def test_a_file_in_a_folder_of_tests_reaches_its_scripts(self):
        self.assertEqual({"script", "layers"}, self.chosen_after_change_of("tests/CMakeLists.txt"))

    def test_a_broken_function_fails(self):
        (self.root / "a.c").write_text(FILES["a.c"].replace("0", "1"))
        self.assertEqual(1, self.near().returncode)

    def test_an_unknown_revision_is_wrong_use(self):
        done = self.near("--since", "nowhere")
        self.assertEqual(2, done.returncode)
        self.assertIn("nowhere", done.stderr)


if __name__ == "__main__":
    unittest.main()
