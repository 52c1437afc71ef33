# SPDX-License-Identifier: Apache-2.0
"""Documents, packages and what users build: each function is a row of ../CMakeLists.txt, which sets the variables in capitals."""
import json
import os
import pathlib
import re
import shutil
import subprocess

import pytest

SOURCE = pathlib.Path(os.environ["SOURCE"])
CMAKE = os.environ["CMAKE"]
README, GUIDE = SOURCE / "README.md", SOURCE / "papers/using.md"


def given(*names):
    return [os.environ[name] for name in names]


def run(*words, folder=None, **env):
    """What a command that ends well prints, standard error included."""
    done = subprocess.run(list(map(str, words)), cwd=folder, env={**os.environ, **env}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, f"{' '.join(map(str, words))}\nended with {done.returncode}:\n{done.stdout}"
    return done.stdout


def configure(source, build, *more):
    return run(CMAKE, "-S", source, "-B", build, "-G", os.environ["GENERATOR"], *more)


def build(folder):
    return run(CMAKE, "--build", folder)


def between(text, begin, end):
    """Fails where either is missing."""
    return text.split(begin, 1)[1].split(end, 1)[0]


# Options for builds that are not there to be fast: -O3 takes three times as long to compile.
FASTER = "-DCELLWALK_OPTIMIZE=OFF", "-DCMAKE_C_FLAGS=-O1"
STRICT = "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow"


# ---- documents ------------------------------------------------------------------------------------------------------------


def test_numbers():
    """No number in src/, simd/ and bench/ is read by a function that depends on the locale, but by src/io/number.h."""
    forbidden = re.compile(r"(?<!\w)(strto(d|f|ld|d_l|f_l)|atof|setlocale|[vf]*s?scanf[^;]*%[0-9.]*l?[aefgAEFG])\W")
    for line in "x = strtod(text, &end);", "*z = strtof(at, NULL);", "return atof(a);", 'sscanf(text, "%lf", &x)', 'fscanf(f, "%9f %d", &x)':
        assert forbidden.search(line), line  # what it should find, it finds
    found, readers = [], 0
    for file in (file for folder in ("src", "simd", "bench") for file in (SOURCE / folder).rglob("*.[ch]")):
        for line in file.read_text().splitlines():
            readers += bool(re.search(r"number_read(_float)?\(", line))
            if forbidden.search(line) and not re.match(r" *(/\*|\* )", line) and file.name != "number.c":
                found.append(f"{file}: {line}")
    assert not found and readers >= 5


def test_papers_references():
    """Each work in papers/references.bib has its line in papers/references.md, and each line its work."""
    entries = re.findall(r"^@[a-z]+{(\w+),$", (SOURCE / "papers/references.bib").read_text(), re.M)
    lines = re.findall(r"^\| ([A-Z]\w*) \|", (SOURCE / "papers/references.md").read_text(), re.M)
    assert entries and sorted(entries) == sorted(lines)


def test_tests_readme():
    """The table in tests/README.md has every test, and no other; a test with emulated kernels stands with the ordinary one."""
    tests = [name for name in os.environ["TESTS"].split(",") if not name.endswith("_avx512_emulated")]
    rows = re.findall(r"^\|( `[^/|\n]*` )\|", between((SOURCE / "tests/README.md").read_text(), "## The claim of each test", "\n## "), re.M)
    assert len(tests) >= 30 and sorted(tests) == sorted(name for row in rows for name in re.findall(r"\w+", row))


def test_example(tmp_path):
    """The C program between the page's markers compiles without a warning, ends well and prints what the page says."""
    page, compiler, flags = given("PAGE", "CC", "FLAGS")
    text, program = (SOURCE / page).read_text(), tmp_path / "example"
    program.with_suffix(".c").write_text(between(text, "<!-- begin:example -->\n```c\n", "```\n<!-- end:example -->"))
    run(compiler, "-std=c17", *STRICT, "-Werror", f"{program}.c", "-o", program, *flags.split(","))
    output = run(program).strip()
    assert output and f"It prints `{output}`" in text


def test_readme_commands(tmp_path):
    """The README's commands under "Try it" run as they stand, with this build's tool, and write the files that they name; so does the Python program
    of papers/using.md. Packages are not installed."""
    tool, python = given("TOOL", "PYTHON")
    commands = between(README.read_text().split("## Try it", 1)[1], "```sh\n", "```")
    commands = re.sub(r"(export PATH|[$][(]command -v sudo[)])[^\n]*\n", "", commands)
    array = re.search(r"/usr/share/[a-z/_-]*[.]npz", commands).group()
    if not os.path.exists(array):
        pytest.skip(f"{array} (Debian: python3-matplotlib) is not there")
    path = f"{os.path.dirname(tool)}:{os.environ['PATH']}"
    done = subprocess.run(["sh", "-euxc", commands], cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, text=True)
    if "was built without" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr
    outputs = re.findall(r"-o ([a-z.]+)", commands)
    assert len(outputs) >= 4 and all((tmp_path / name).exists() for name in outputs)
    (tmp_path / "guide.py").write_text(re.search(r"```python\n((?:(?!```).)*print[^\n]*\n)```", GUIDE.read_text(), re.S).group(1))
    assert "of the rays hit" in run(python, "-B", "guide.py", folder=tmp_path, PATH=path)


# ---- man pages and completions: what --help says ----------------------------------------------------------------------------


def folded(text):
    return re.sub(r"[ \n]+", " ", text).strip()


def check_page(file, help):
    """Every word of the help, in its order; groff has no warning."""
    page = folded(run("groff", "-man", "-ww", "-Tascii", "-P-cbou", file))
    help = re.sub(r"\nMore:.*", "", help, flags=re.S)  # the program's last lines are about other pages
    help = re.sub(r"\n(Commands|Options|Examples):\n", "@", help)
    help = re.sub(r"^Usage: ([^\n]*)\n\n?", r"\1@", help)
    help = re.sub(r"(\n  [^\n]*)\n([^ \n])", r"\1@\2", help)  # a list ends: the page has a heading there
    for part in re.split(r"@|\n\n+", help):
        assert folded(part) in page, (file, part)


COMPLETE = """
source "$3"
COMP_CWORD=$2 COMP_WORDS=("${@:4}")
$1
echo "${COMPREPLY[@]}"
"""


def test_pages(tmp_path):
    program, pages = given("PROGRAM", "PAGES")
    if not shutil.which("groff") or not shutil.which("bash"):
        pytest.skip("groff or bash (Debian: groff-base, bash) not found")
    name = os.path.basename(program)
    (tmp_path / "a.npy").touch()  # the only file that there is to complete
    (tmp_path.parent / "complete.bash").write_text(COMPLETE)
    home = str(tmp_path.parent / "home")  # nobody's own settings
    settings = {"HOME": home, "XDG_CONFIG_HOME": home, "XDG_DATA_HOME": home, "TERM": "dumb",
                "PATH": f"{os.path.dirname(program)}:{os.environ['PATH']}"}

    def check_completion(line, wanted):
        """bash completes the last of the words. What it offers is the list, in any order."""
        words = [part for word in line.split(" ") for part in (["--isa", "=", word[6:]] if word.startswith("--isa=") else [word])]  # as bash breaks them
        got = run("bash", tmp_path.parent / "complete.bash", "_" + name.replace("-", "_"), len(words) - 1,
                  f"{pages}/bash-completion/completions/{name}", *words, folder=tmp_path, **settings)
        assert sorted(got.split()) == sorted(wanted), line

    help = run(program, "--help")
    check_page(f"{pages}/man/man1/{name}.1", help)
    commands = re.findall(r"\n  ([a-z]+) ", re.search(r"Commands:(\n  [^\n]*)+\n", help).group())
    assert len(commands) >= 2
    checked = False
    for command in commands:
        help = run(program, command, "--help")
        check_page(f"{pages}/man/man1/{name}-{command}.1", help)
        options = re.findall(r"-[a-z-]+", " ".join(re.findall(r"\n  ((?:-[a-z],|   ) --[a-z-]+)", help.split("\nExamples:")[0])))
        check_completion(f"{name} {command} -", options)
        if "--isa" in options and not checked:
            check_completion(f"{name} {command} --isa av", ["avx2", "avx512"])
            check_completion(f"{name} {command} --isa=sc", ["scalar"])
            check_completion(f"{name} {command} --threads ", [])
            checked = True
    check_completion(f"{name} ", [*commands, "--help", "--version"])
    check_completion(f"{name} --ver", ["--version"])
    check_completion("cellwalk render --output ", ["a.npy"])
    check_completion("cellwalk render a", ["a.npy"])


# ---- the libraries ----------------------------------------------------------------------------------------------------------


def check_names(library, *options):
    """Only names that begin with cw_ leave a library."""
    nm = "nm" if "--with-symbol-versions" in options else os.environ["NM"]  # not in LLVM 14
    names = re.findall(r"[ \t][B-TV-Z] (\S+)", run(nm, *options, "--defined-only", library))
    assert len(names) >= 10 and all(name.startswith("cw_") for name in names), names
    return names


def check_versions(library, header):
    """Exactly the names of src/package/debian/symbols.in, for as long as the soname stays, with CELLWALK_1.0 for those of the header."""
    versioned = sorted(name.replace("@@", "@") for name in check_names(library, "-D", "--with-symbol-versions"))
    file = (SOURCE / "src/package/debian/symbols.in").read_text()
    listed = re.findall(r"^ (cw_\S+) ", between(file + "lib", f"{pathlib.Path(library).name.split('.so')[0]}.so.", "\nlib"), re.M)
    assert versioned == listed
    public = set(re.findall(r"^CW_API\b[^;(]*?(\w+)\(", (SOURCE / "include" / header).read_text(), re.M))
    assert public == {name.split("@")[0] for name in listed if name.endswith("@CELLWALK_1.0")} and len(public) >= 12


def test_symbols():
    """What the libraries show to the linker and what is in their code."""
    objdump = os.environ["OBJDUMP"]
    for static in os.environ["STATIC"], os.environ["TERRAIN_STATIC"]:
        check_names(static, "-g")
    if os.environ["SHARED"]:
        for library, header in (os.environ["SHARED"], "cellwalk.h"), (os.environ["TERRAIN"], "cellwalk_terrain.h"):
            check_versions(library, header)
            for needed in re.findall(r"NEEDED +(.+)", run(objdump, "-p", library)):
                assert re.search(r"(libc|libm|libpthread|ld-linux[^.]*|libcellwalk)\.so", needed), needed
    # Nothing is fused, or results would depend on which instruction set a kernel was compiled for; but vf_mul_sub, whose product is exact.
    objects = os.environ["OBJECTS"].split(",")
    avx = False
    for object in objects:
        code = run(objdump, "-d", "--no-show-raw-insn", object)
        avx = avx or "vmulps" in code
        code = re.sub(r"\tvfm(add|sub)\d+ps\s+\{rn-sae\},\s*%zmm", "", code)  # Clang may add what it has negated
        assert not re.search(r"vfn?m(add|sub)[0-9a-z]*|\tfn?m(add|sub)\t|\tfml[as]\t", code), object  # x86-64's, aarch64's
    assert any("/query.c" in object for object in objects)
    simd = os.environ["SIMD"] == "ON"
    assert avx or not simd or os.environ["X86_64"] in ("", "0", "FALSE", "OFF")


SSE4 = (r"[ \t](roundp[sd]|rounds[sd]|blendvp[sd]|pblendvb|ptest|pinsr[bdq]|pextr[bdq]|pmulld|insertps|extractps|pm(in|ax)s[bd]|pm(in|ax)u[dw]|"
        r"pcmpgtq|pcmpestri|pcmpistri)[ \t]")
AVX, AVX512 = r"[ \t]v[a-z0-9]+[ \t].*%[xyz]mm", "%(zmm|k[1-7])"
OLD_CPUS = {"core2duo": ([], [SSE4, AVX]), "Nehalem": ([SSE4], [AVX]), "Haswell": ([AVX], [AVX512])}  # what kernels use of it; what it lacks


def test_old_cpu(tmp_path):
    """No instruction that is translated for an emulated CPU is one that the CPU lacks. (The emulator itself would run it.)"""
    qemu, cpu, lanes, simd = given("QEMU", "CPU", "TEST", "SIMD")
    log = tmp_path / "log"
    run(qemu, "-cpu", cpu, "-d", "in_asm", "-D", log, lanes, "known", "adversarial", "few*", "stress*", CELLWALK_TEST_DIVIDE="1000")
    if "%xmm" not in log.read_text():
        pytest.skip("this emulator cannot show instructions")
    # The emulator's disassembler reads in chunks: an instruction cut in two is shown as bytes, and lines after them start in the middle of one.
    # Up to the end of the block they need not be instructions of the program.
    code = re.sub(r"[.]byte.*(\n0x.*)*", "", log.read_text())
    used, lacking = OLD_CPUS[cpu]
    assert not any(re.search(kind, code) for kind in lacking), cpu
    assert simd != "ON" or all(re.search(kind, code) for kind in used), cpu


def test_emulation():
    """A program with emulated kernels has no instruction of AVX-512, where the ordinary one has many, and more of AVX2 than that."""
    programs = [run(os.environ["OBJDUMP"], "-d", "--no-show-raw-insn", program) for program in given("EMULATED", "ORDINARY")]
    (wide, ordinary_wide), (narrow, ordinary_narrow) = ([code.count(name) for code in programs] for name in ("%zmm", "%ymm"))
    assert wide == 0 and ordinary_wide > 1000 and narrow > ordinary_narrow


def test_install(tmp_path):
    """Installs the build into a fresh tree, moves the tree, or takes that of ./round_trip, and builds and runs programs against it: once through the CMake package and
    once through pkg-config, linked as it comes and statically."""
    library, package, cxx, config = given("LIBRARY", "PACKAGE", "CXX", "CONFIG")
    programs, work = [SOURCE / "tests/package" / os.environ["PROGRAM"]], tmp_path / "build"
    if library == "terrain":
        programs.append(shutil.copy(programs[0], tmp_path / "viewshed.cpp"))
    compilers = {".c": (os.environ["CC"], "-std=c17"), ".cpp": (cxx, "-std=c++17")}
    tree = os.environ.get("TREE")
    if not tree:
        run(CMAKE, "--install", os.environ["BUILD"], "--prefix", tmp_path / "first")
        tree = (tmp_path / "first").rename(tmp_path / "tree")  # nothing may know where it was installed to
    pages = list(pathlib.Path(tree).rglob("doc/libcellwalk-dev/*.md"))
    assert sorted(page.name for page in pages) == ["numerics.md", "terrain.md", "using.md"]
    for page in pages:
        assert all((page.parent / link).exists() for link in re.findall(r"\]\(([^)#]*)", page.read_text())), page
    configure(SOURCE / "tests/package/users", work, f"-DCMAKE_PREFIX_PATH={tree}", f"-DCMAKE_BUILD_TYPE={config}", f"-DLIBRARY={library}",
              f"-DPROGRAMS={';'.join(map(str, programs))}")  # by the compilers CC and CXX
    build(work)
    for program in programs:
        for kind in "", "_static":
            run(work / f"{program.name}{kind}")
    if not shutil.which("pkg-config"):
        pytest.skip("without pkg-config (Debian: pkg-config) its file is not tested")
    pc, *_ = pathlib.Path(tree).rglob(f"{package}.pc")
    for kind, flag, link in ("shared", [], []), ("static", ["--static"], ["-static"]):
        flags = run("pkg-config", "--cflags", "--libs", *flag, package, PKG_CONFIG_PATH=str(pc.parent)).split()
        for program in programs:
            made = tmp_path / f"{program.name}-{kind}"
            run(*compilers[program.suffix], *link, program, "-o", made, *flags)
            run(made, LD_LIBRARY_PATH=str(pc.parent.parent))


VALUES = ("CW_ERROR_ARGUMENT == 1 && CW_ERROR_SAMPLE == 2 && CW_ERROR_KERNEL == 3 && CW_ERROR_NOT_BUILT == 4 && CW_ERROR_MEMORY == 5 && CW_ERROR_BUSY == 6 && "
          "CW_ERROR_CANCELLED == 7 && CW_OK == 0 && CW_COPY == 0 && CW_ISA_ANY == 0 && CW_LEAF_DEFAULT == 0 && CW_TRIANGLE_A == 0")


def layout_in_c():
    """Sizes of what the public headers declare, and the places of its members, which never change within a major version. In C99 and C++98: an array
    whose size is negative where something is not so."""
    same = [VALUES]
    for name, size, *places in map(str.split, (SOURCE / "tests/package/layout.txt").read_text().splitlines()):
        same += [f"sizeof({name}) == {size}", *(f"offsetof({name}, {member}) == {place}" for member, place in zip(places[::2], places[1::2]))]
    return "#include <cellwalk_expert.h>\n#include <cellwalk_terrain.h>\n" + "".join(f"typedef char same{k}[({what}) ? 1 : -1];\n" for k, what in enumerate(same))


def test_cplusplus(tmp_path):
    """The public headers compile as C99 to C2x and C++98 to C++23 without a warning, with that layout, also where enumerations are
    short; a program as C++14 and later."""
    layout = tmp_path / "layout.c"
    layout.write_text(layout_in_c())
    c, cxx = (names.split(",") for names in given("C_COMPILERS", "COMPILERS"))
    cases = [(compiler, standard, *more, layout) for compiler in c for standard in ("c99", "c11", "c17", "c2x") for more in ((), ("-fshort-enums",))]
    cases += [(compiler, standard, "-x", "c++", layout) for compiler in cxx for standard in ("c++98", "c++11", "c++14", "c++17", "c++20", "c++2b")]
    cases += [(compiler, standard, "-Wold-style-cast", "-x", "c++", SOURCE / "tests/package/viewshed.c") for compiler in cxx for standard in ("c++14", "c++17", "c++20")]
    assert len(cases) >= 17
    for compiler, standard, *words in cases:
        strict = ["-Weverything", "-Wno-padded"] if "clang" in compiler and words[-1] == layout else STRICT
        run(compiler, f"-std={standard}", *strict, "-Werror", f"-I{SOURCE}/include", "-c", *words, "-o", tmp_path / "object.o")


def test_install_after_table():
    """README's first command builds the target table and nothing else; cmake --install has to find all that it installs. So every installed file that
    is built has to be among the target's inputs."""
    folder, ninja = given("BUILD", "NINJA")
    needed = run(ninja, "-C", folder, "-t", "inputs", "table").splitlines()
    built = [line.split(": ")[0] for line in run(ninja, "-C", folder, "-t", "targets", "all").splitlines()
             if ": CMAKE_SYMLINK_LIBRARY" not in line]  # one step makes both links, of which one is named
    needed, built = ({re.sub(r"^.*/([^/]+_pages)$", r"\1", name) for name in names} for names in (needed, built))
    count = 0
    for script in pathlib.Path(folder).rglob("cmake_install.cmake"):
        if script.is_relative_to(f"{folder}/tests"):  # tests that run beside this one configure projects there, whose files come and go
            continue
        for file in re.findall(rf'"{re.escape(folder)}/([^"]+)"', script.read_text()):
            pages = re.match(r"share/([^/]+)/", file)  # a folder: ninja 1.11 lists the target that writes it, but not its stamp
            file = f"{pages.group(1)}_pages" if pages else file
            count += file in built
            assert file not in built or file in needed, f"{file} is installed, but not built by the target table"
    assert count >= 2


# ---- other builds -----------------------------------------------------------------------------------------------------------


def check_optimised(folder, vendored):
    """The last -O flag of each command decides: -O3 even in a parent without a build type, and in one that debugs itself."""
    commands = [c["command"] for c in json.loads((folder / "compile_commands.json").read_text()) if re.search(rf"{vendored}/(src|simd)/.* -c ", c["command"])]
    assert len(commands) >= 10
    for command in commands:
        assert re.findall(r" -O[0-9a-z]+", command)[-1] in (" -O2", " -O3"), command


def test_subproject(tmp_path):
    """Cellwalk as a part of another project, as a static library, which comes without a word about it, and as a shared one: configures, builds, runs, and
    adds nothing to what that installs. The parent is compiled with -ffast-math, which Cellwalk takes back for itself."""
    vendored = tmp_path / "vendored"  # what is enough to take the library's source along
    for part in "CMakeLists.txt", "include", "simd", *VENDORED:
        (vendored / part).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (SOURCE / part).is_dir() else shutil.copy)(SOURCE / part, vendored / part)
    folder = tmp_path / "build"
    parents = {"static": [], "shared": ["-DCMAKE_BUILD_TYPE=Debug", "-DBUILD_SHARED_LIBS=ON", "-DCELLWALK_OPTIMIZE=ON"]}
    for kind, options in parents.items():
        configure(SOURCE / "tests/package/subproject", folder, f"-DCMAKE_C_COMPILER={os.environ['CC']}", f"-DCELLWALK={vendored}",
                  "-DFETCHCONTENT_FULLY_DISCONNECTED=ON", "-DCMAKE_C_FLAGS=-ffast-math", *options)
        check_optimised(folder, vendored)
        # The same commands for both, so that each file is compiled once. Without optimisation -ffast-math changes little, but then src/core/ieee.h
        # sees it in every kernel.
        run(CMAKE, *FASTER[:1], "-DCMAKE_BUILD_TYPE=", "-DCMAKE_C_FLAGS=-O1 -ffast-math -ffinite-math-only -funsafe-math-optimizations", folder)
        build(folder)
        assert bool(list(folder.rglob("*.so"))) == (kind == "shared")
        run(folder / "same_bits")
        run(CMAKE, "--install", folder, "--prefix", tmp_path / kind)
        assert [str(file.relative_to(tmp_path / kind)) for file in (tmp_path / kind).rglob("*") if file.is_file()] == ["bin/same_bits"]


VENDORED = "src/base", "src/core", "src/scalar", "src/flags.cmake"


def test_elsewhere(tmp_path):
    """The libraries for other systems and C libraries, with warnings as errors: Windows by mingw-w64, musl. Each must print the line that the native
    build prints, and the program that computes a viewshed must end well. Programs for Windows are only built where Wine is missing. The compiler for musl is the native one, so vector kernels are left out."""
    native, musl, mingw, wine = given("NATIVE", "MUSL", "MINGW", "WINE")
    wanted = run(native)
    source = tmp_path / "source"
    source.mkdir()
    (source / "CMakeLists.txt").write_text(f"""cmake_minimum_required(VERSION 3.22)
project(elsewhere LANGUAGES C)
add_subdirectory({SOURCE} cellwalk)
add_executable(same_bits {SOURCE}/tests/package/same_bits.c)
target_link_libraries(same_bits PRIVATE cellwalk::cellwalk_static)
add_executable(viewshed {SOURCE}/tests/package/viewshed.c)
target_link_libraries(viewshed PRIVATE cellwalk::terrain_static)
""")
    faster = "-DCELLWALK_WERROR=ON", "-DCELLWALK_TERRAIN=ON", *FASTER
    if musl:
        configure(source, tmp_path / "musl", *faster, "-DCELLWALK_SIMD=OFF", f"-DCMAKE_C_COMPILER={musl}", "-DCMAKE_EXE_LINKER_FLAGS=-static")
        build(tmp_path / "musl")
        assert run(tmp_path / "musl/same_bits").split("hits")[1] == wanted.split("hits")[1]
        run(tmp_path / "musl/viewshed")
    if mingw:
        configure(source, tmp_path / "mingw", *faster, f"-DCMAKE_TOOLCHAIN_FILE={SOURCE}/.ci/mingw.cmake", f"-DCMAKE_C_COMPILER={mingw}")
        build(tmp_path / "mingw")
        if wine:
            output, _ = (run(wine, tmp_path / f"mingw/{name}.exe", WINEPREFIX=str(tmp_path / "wine"), WINEDEBUG="-all") for name in ("same_bits", "viewshed"))
            assert output.strip() == wanted.strip()


def test_amalgamation(tmp_path):
    """One command compiles the target amalgamation without a warning. Though GCC would fuse a multiply and an add with these options, each instruction
    set that the CPU has gives the bits of the library."""
    native, mingw, compilers = given("NATIVE", "MINGW", "C_COMPILERS")
    run(CMAKE, "--build", os.environ["BUILD"], "--target", "amalgamation")
    made = pathlib.Path(os.environ["BUILD"], "amalgamation")
    sources = sorted(made.glob("*.c"))
    assert len(sources) == 10 and [file.name for file in sorted(made.glob("*.h"))] == ["cellwalk.h", "cellwalk_expert.h"]
    strict = "-Wall", "-Wextra", "-Werror", "-Wno-ignored-optimization-argument", "-c"
    for compiler in compilers.split(","):
        folder = tmp_path / compiler.replace("/", "_")
        folder.mkdir()
        run(compiler, "-O1", "-fexpensive-optimizations", *strict, *sources, folder=folder)
        run(compiler, f"-I{made}", SOURCE / "tests/package/same_bits.c", *folder.glob("*.o"), "-o", "same_bits", "-lm", "-pthread", folder=folder)
        assert run(folder / "same_bits") == run(native)
    if mingw:  # the rest of it does what GCC does
        run(mingw, "-fsyntax-only", *strict, *sources)


def test_parts(tmp_path):
    """Optional parts: configuring says which are found and which are not, README's install command has a package for each, and `cellwalk --version`
    says which work."""
    tool, gdal, bench = given("TOOL", "GDAL", "BENCH")
    install = between(README.read_text(), "<!-- begin:install -->", "<!-- end:install -->")
    packages = re.findall(r"^ +cellwalk_part\([^ ]+ ([^ ]+) ", (SOURCE / "src/parts.cmake").read_text(), re.M)
    assert len(packages) >= 9 and all(f" {package} " in install for package in packages)
    options = f"-DCMAKE_C_COMPILER={os.environ['CC']}", "-DCELLWALK_TESTS=OFF"
    missing = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{part}=ON" for part in ("GDAL", "OpenEXR", "PNG")]
    said = configure(SOURCE, tmp_path / "without", *options, "-DCELLWALK_BENCH=OFF", *missing)
    assert re.search(r"Optional parts not found:.  GDAL \(Debian: libgdal-dev\): no GeoTIFF[^\n]*.  OpenEXR [^\n]*.  libpng ", said, re.S)
    if gdal == "1":
        said = configure(SOURCE, tmp_path / "with", *options, "-DCELLWALK_BENCH=ON")
        assert re.search("Optional parts found: GDAL" + (", .*pkg-config, jansson" if bench == "1" else ""), said)
        assert re.search("GDAL +yes", run(tool, "--version"))
    assert re.search("GDAL +no.*OpenEXR +(yes|no).*libpng +(yes|no)", run(tool, "--version", CELLWALK_MODULES="/nowhere"), re.S)
