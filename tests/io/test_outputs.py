# SPDX-License-Identifier: Apache-2.0
"""Output files appear whole or not at all, and whose the new file is that takes an old one's place. What only root can try, or only
some file systems have, is left out elsewhere, with a word."""
import os
import resource
import stat
import struct

import pytest
from words import Files
from program import entries, read, write

ROOT, NOBODY, OTHER = os.geteuid() == 0, 65534, 12345


def needs_root(test):
    """Only root can be or have a second user; other users leave these tests out, and nothing counts as skipped."""
    return test if ROOT else None


def start(files, name, text="new", output=0):
    files("open", output, name)
    files("write", output, text)


def put(files, name, text="new"):
    start(files, name, text)
    files("commit", 0)


def limit(files, size):
    """The size of files from now on, which stands for a disk that is full; the old one."""
    return resource.prlimit(files.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))[0]


# ---- whole or not at all ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("old", [None, "old"])
def test_the_name_comes_with_the_last_byte(files, old):
    if old:
        write("a", old)
    before = entries()
    for end in "discard", "commit":
        start(files, "a")
        assert len(entries()) == len(before) + 1 and (not old or read("a") == b"old")
        files(end, 0)
        assert entries() == (before if end == "discard" else ["a"])
    files("discard", 0)  # does nothing now
    assert read("a") == b"new" and entries() == ["a"]


def test_links_are_followed(files):
    """Also those that lead to no file yet, over another link and from another folder."""
    os.mkdir("folder")
    os.symlink("../file", "folder/second")
    os.symlink("folder/second", "first")
    for text in "one", "two":
        put(files, "first", text)
        assert read("file") == text.encode() and os.path.islink("first") and os.path.islink("folder/second")


def test_descriptors_are_written_to_as_they_are():
    """A shell has opened the file, to append to it."""
    os.symlink("/dev/stdout", "link")
    write("log", "old ")
    with open("log", "ab") as log:
        files = Files(stdout=log, pass_fds=[log.fileno()])
        for name in "/dev/stdout", "link", "-", f"/dev/fd/{log.fileno()}", "/proc/self/fd/1":
            put(files, name, "new ")
        files.end()
    assert read("log") == b"old " + 5 * b"new " and entries() == ["link", "log"]


def test_all_can_be_discarded(files):
    for k, name in enumerate("abc"):
        start(files, name, str(k), k)
    assert len(entries()) == 3
    files("commit", 0)
    hidden = [name for name in entries() if name.startswith(".b")]
    files("discard all")
    assert entries() == ["a"]
    write(hidden[0], "2")  # as where a second signal comes before the first one's handler has removed the file
    files("discard all")
    assert entries() == ["a"]
    files.refused("b: cannot write", "commit", 1)
    files("discard", 2)
    assert entries() == ["a"] and read("a") == b"0"
    for k in range(64):  # their places are free again
        start(files, "d", "4", k)
    files.refused("", "open", 64, "e")
    assert {len(name) for name in entries()} == {1, len(".d.") + 16 + len(".tmp")}
    files("discard all")
    assert entries() == ["a"]


def test_names_taken_meanwhile_are_replaced(files):
    """By another program's file, and by another output's; in no way can a folder be."""
    start(files, "a", "mine")
    write("a", "theirs")
    files("commit", 0)
    assert read("a") == b"mine"
    start(files, "a", "first")
    start(files, "a", "second", 1)
    files("commit", 1)
    files("commit", 0)
    assert read("a") == b"first" and entries() == ["a"]
    start(files, "b")
    os.mkdir("b")
    files.refused("b: cannot write: Is a directory", "commit", 0)
    os.mkdir("c")
    start(files, "c/a")
    os.system("rm -r c")
    files.refused("c/a: cannot write: No such file", "commit", 0)
    assert entries() == ["a", "b"]


def test_bytes_are_on_the_disk_before_the_name(files):
    """A machine that stops has the old file or the new one, and not an empty one."""
    for _ in range(2):
        files("events")
        put(files, "a", "text")
        assert files("events").split() == ["fsync", "rename"]
    start(files, "a", "other")
    files("break fsync", 1)
    assert files.refused("", "commit", 0) == "a: cannot write: Input/output error"
    assert read("a") == b"text" and entries() == ["a"]


def test_bad_targets_are_refused(files):
    os.mkdir("folder")
    os.symlink("loop", "loop")
    for name in "", "folder", "folder/", "absent/a", "folder/../absent/a", "loop":
        assert files.refused(name, "open", 0, name) != ""
        files("discard", 0)
    assert entries() == ["folder", "loop"]


def test_files_named_like_unfinished_ones_stay(files):
    os.symlink("kept", ".a.tmp")
    write("a.part", "mine")
    put(files, "a")
    assert os.path.islink(".a.tmp") and read("a.part") == b"mine" and entries() == [".a.tmp", "a", "a.part"]


def test_a_full_disk_is_an_error(files):
    """Found out when writing, or as late as when the stream is flushed. Of two files that belong together neither gets its name
    then."""
    start(files, "/dev/null")
    files("commit", 0)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    start(files, "/dev/full", "text")
    assert files.refused("", "commit", 0) == "/dev/full: cannot write: No space left on device"
    write("a", "old")
    write("b", "old")
    old = limit(files, 1024)
    start(files, "c")
    files.refused("c: cannot write: File too large", "write", 0, 8192 * "x")
    files("discard", 0)
    start(files, "a")
    start(files, "b", 1030 * "x", 1)
    assert files.refused("", "settle", 1) == "b: cannot write: File too large"
    files("discard", 0)
    assert (read("a"), read("b"), entries()) == (b"old", b"old", ["a", "b"])
    limit(files, old)
    start(files, "a")
    start(files, "b", output=1)
    for words in ("settle", 1), ("commit", 0), ("commit", 1):
        files(*words)
    assert (read("a"), read("b"), entries()) == (b"new", b"new", ["a", "b"])


def test_each_process_removes_its_own(files):
    """A forked child that ends removes none of its parent's files. A process that ends leaves no unfinished file."""
    start(files, "a", "te")
    files("flush", 0)
    for words in ("discard", 0), ("discard all",), ("open", 1, "b"):
        files("in child", *words)
    assert len(entries()) == 1
    files("write", 0, "xt")
    files("commit", 0)
    assert read("a") == b"text" and entries() == ["a"]


@pytest.mark.parametrize("given, shown", [
    ("café € 🏔", "café € 🏔"), ("a\x1b[2Jb\x7f\n", "a?[2Jb??"), (b"a\xc2\x9bb", "a??b"),
    (b"a\x9b31m", "a?31m"),  # alone
    ("exe\u202etxt.npy", "exe???txt.npy"), ("\u2066x\u200f", "???x???"),
    (b"\xe2\x80", "??"),  # cut off
    (b"\xc0\x9b\xe0\x82\x9b\xf0\x80\x82\x9b", "?????????"),  # C1 spelt too long
    (b"\xed\xa0\x80\xf4\x90\x80\x80\xff", "????????")])
def test_messages_are_text(files, given, shown):
    """Bytes that are no text, or command a terminal."""
    assert files.refused("", "message", given) == shown


# ---- what outputs do not replace ------------------------------------------------------------------------------------------------


def test_inputs_are_not_replaced():
    """By whatever name: spelt otherwise, linked softly or hard. Only once a program has asked for it."""
    for name in "in", "later":
        write(name, "input")
    os.symlink("in", "soft")
    os.link("in", "hard")
    with open("in", "ab") as file:
        files = Files(stdout=file)
        files("read", "in")
        start(files, "in")  # not protected yet
        files("discard", 0)
        files("protect inputs")
        files("read", "in")
        for name in "in", "./in", "soft", "hard":
            assert files.refused("is also an input", "open", 0, name).startswith(name)
        files.refused("standard output: is also an input", "open", 0, "-")
        start(files, "later")
        files("read", "later")
        files.refused("later: is also an input", "commit", 0)
        files.end()
    assert read("in") == read("later") == b"input" and entries() == ["hard", "in", "later", "soft"]


def test_outputs_differ():
    """One file by two names, whether it exists or not."""
    os.mkdir("folder")
    os.symlink("folder", "way")
    os.symlink("new", "soft")
    write("old", "old")
    os.link("old", "hard")
    before = entries()
    with open("old", "ab") as old:
        files = Files(pass_fds=[old.fileno()])
        files("protect inputs")
        number = f"/dev/fd/{old.fileno()}"
        for pair in [("new", "./new"), ("new", "soft"), ("folder/a", "way/a"), ("new", "folder/../new"), ("old", "hard"), ("old", "./old"),
                     ("folder/a", "folder//a"), ("soft", "./soft"), ("hard", "folder/../old"), (number, "old")]:
            for one, other in pair, pair[::-1]:
                start(files, one, "")
                assert files.refused("is also another output", "open", 1, other).startswith(other)
                files("discard", 0)
        for one, other in ("folder/new", "new"), ("/dev/null", "/dev/null"):  # the same name elsewhere; what is no file
            start(files, one)
            start(files, other, output=1)
            for k in range(2):
                files("discard", k)
        files.end()
    assert read("old") == b"old" and entries() == before


@pytest.mark.parametrize("stream, said", [("stdout", "where standard output leads"), ("stderr", "where standard error leads")])
def test_streams_are_no_outputs(stream, said):
    write("log", "old ")
    os.symlink("log", "link")
    with open("log", "ab") as log:
        files = Files(**{stream: log})
        files("protect inputs")
        files.refused(said, "open", 0, "link")
        start(files, "-")
        files("commit", 0)
        files.end()
    assert read("log") == (b"old new" if stream == "stdout" else b"old ")


# ---- rights -----------------------------------------------------------------------------------------------------------------


def old_file(name, mode, owner=-1, group=-1):
    if os.path.lexists(name):
        os.unlink(name)
    write(name, "old")
    os.chown(name, owner, group)
    os.chmod(name, mode)
    assert stat.S_IMODE(os.stat(name).st_mode) == mode


def is_now(name, mode, owner=os.geteuid(), group=os.getegid()):
    now = os.stat(name)
    assert (stat.S_IMODE(now.st_mode), now.st_uid, now.st_gid, now.st_size) == (mode, owner, group, 3), (name, oct(now.st_mode))


def replaced(files, name, mode, owner=os.geteuid(), group=os.getegid()):
    """At no time may anyone do more with the new file than the mode lets him."""
    files("events")
    start(files, name)
    early, = (entry for entry in os.scandir(os.path.dirname(name) or ".") if ".tmp" in entry.name)
    assert stat.S_IMODE(early.stat().st_mode) & ~mode == 0 and (mode & 0o77 or "open-to-others" not in files("events"))
    files("commit", 0)
    is_now(name, mode, owner, group)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o666, 0o755, 0o777, 0o200, 0o1644, 0o2755, 0o4755, 0o6777, 0o7777])
def test_modes_are_kept_without_special_bits(files, mode):
    """A second name keeps the old file."""
    old_file("a", mode)
    os.link("a", "b")
    replaced(files, "a", mode & 0o777)
    assert read("b") == b"old"


@pytest.mark.parametrize("mask", [0, 0o22, 0o27, 0o77])
def test_new_files_have_the_rights_of_the_umask(mask):
    files = Files(umask=mask)
    replaced(files, "a", 0o666 & ~mask)
    files.end()


@needs_root
def test_owner_and_group_are_kept(files):
    """Root writes over another user's file: it stays his, and gets none of root's rights."""
    for mode, owner, group in (0o4777, NOBODY, OTHER), (0o640, NOBODY, 0), (0o2664, 0, OTHER):
        old_file("a", mode, owner, group)
        replaced(files, "a", mode & 0o777, owner, group)


@pytest.fixture
def nobody(folder):
    """The program as a user without rights, and a folder that it may write to."""
    os.mkdir("shared")
    os.chmod("shared", 0o777)
    files = Files(umask=0o22)
    files("become", NOBODY)
    yield files
    files.end()


@needs_root
def test_strangers_files_give_no_rights(nobody):
    """Who may not give a file its old owner gets a file of the usual rights: those of the old one were for others. So are a group's
    that cannot be kept."""
    for mode, owner, now in (0o666, OTHER, 0o644), (0o4777, OTHER, 0o644), (0o2777, OTHER, 0o644), (0o664, NOBODY, 0o644), (0o660, NOBODY, 0o600):
        old_file("shared/a", mode, owner, OTHER)
        put(nobody, "shared/a")
        is_now("shared/a", now, NOBODY, NOBODY)


@needs_root
def test_strangers_links_are_not_followed(files, nobody):
    """As Linux itself has it: anybody can put a link into a shared folder."""
    os.chmod("shared", 0o1777)
    write("target", "old")
    os.symlink("../target", "shared/link")
    os.lchown("shared/link", OTHER, OTHER)
    for who in files, nobody:
        who.refused("Permission denied", "open", 0, "shared/link")
    os.chmod("shared", 0o777)  # where links are not protected
    start(files, "shared/link")
    files("discard", 0)
    os.chmod("shared", 0o1777)
    os.lchown("shared/link", 0, 0)  # the folder's owner's, and one's own
    start(files, "shared/link")
    files("discard", 0)
    assert read("target") == b"old"


@needs_root
def test_sidecars_that_stay_are_named(nobody):
    """The new picture stays, and the user learns what is wrong beside it."""
    if not nobody.ask("can write", "a.png", 1)[0]:
        pytest.skip("this build lacks libpng")
    os.chmod("shared", 0o1777)
    os.mkdir("shared/work")
    os.chown("shared/work", NOBODY, NOBODY)
    write("cells", bytes(12))
    os.chmod("cells", 0o644)
    old_file("shared/a.png", 0o644, NOBODY, NOBODY)
    old_file("shared/a.png.ovr", 0o644, OTHER, OTHER)
    nobody.refused("shared/a.png.ovr of the file before it cannot be", "raster write", "shared/a.png", "nx=2 ny=2")
    assert os.path.getsize("shared/a.png") > 3 and read("shared/a.png.ovr") == b"old"


# user::rw-, user:12345:rw-, group::---, mask::rw-, other::---: the mode's bits for the group are the mask.
LIST = b"\2\0\0\0" + b"".join(struct.pack("<HHI", *entry) for entry in (
    (1, 6, 2**32 - 1), (2, 6, OTHER), (4, 0, 2**32 - 1), (16, 6, 2**32 - 1), (32, 0, 2**32 - 1)))
ACCESS, DEFAULT = "system.posix_acl_access", "system.posix_acl_default"


def test_lists_are_kept(files):
    """A list that the folder gives new files is not for one that replaces a file without."""
    if os.environ.get("CELLWALK_PORTABLE") == "ON":
        pytest.skip("built without what Linux alone has")
    old_file("a", 0o600)
    try:
        os.setxattr("a", ACCESS, LIST)
    except OSError:
        pytest.skip("this file system has no access control lists")
    replaced(files, "a", 0o660)
    assert os.getxattr("a", ACCESS) == LIST
    os.mkdir("folder")
    os.setxattr("folder", DEFAULT, LIST)
    old_file("folder/a", 0o640)
    os.removexattr("folder/a", ACCESS)
    os.chmod("folder/a", 0o640)
    replaced(files, "folder/a", 0o640)
    assert ACCESS not in os.listxattr("folder/a")
    os.unlink("folder/a")
    put(files, "folder/a")
    assert os.getxattr("folder/a", ACCESS) == LIST
