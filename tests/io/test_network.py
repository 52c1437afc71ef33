# SPDX-License-Identifier: Apache-2.0
"""The filter that closes the network to the program, tried call by call in forked children."""
import ctypes
import errno
import mmap
import multiprocessing
import os
import socket
import subprocess
import sys
import threading

import pytest

LIBC, X86_64 = ctypes.CDLL(None, use_errno=True), os.uname().machine == "x86_64"
SOCKET, IO_URING_SETUP, X32 = 41, 425, 0x40000000


def status_of_child(function, *arguments):
    child = multiprocessing.get_context("fork").Process(target=function, args=arguments)
    child.start()
    child.join()
    return child.exitcode


def in_child(function, *arguments):
    assert status_of_child(function, *arguments) == 0


def close_network():
    """A second time does no harm."""
    library = ctypes.CDLL(os.path.join(os.environ["CELLWALK_PROGRAMS"], "cellwalk_test_network.so"))
    assert [library.network_close(ctypes.create_string_buffer(1 << 16)) & 1 for _ in range(2)] == [1, 1]


def no_sockets(said=None):
    for family in range(64):
        for kind in 1, 2, 3:
            with pytest.raises(OSError) as refusal:
                socket.socket(family, kind)
            assert refusal.value.errno == errno.EACCES
    for call in [(IO_URING_SETUP, 1, None)] + [(X32 | SOCKET, 2, 1, 0)] * X86_64:
        assert LIBC.syscall(*call) == -1 and ctypes.get_errno() == errno.EACCES
    for one in socket.socketpair():  # leads nowhere else
        one.close()
    if said:
        said.set()


def threads_and_children():
    """Also a thread that runs already, and another program."""
    go, done = threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: (go.wait(), no_sockets(done)), daemon=True)
    thread.start()
    socket.socket(socket.AF_UNIX).close()
    close_network()
    go.set()
    thread.join()
    assert done.is_set()
    no_sockets()
    in_child(no_sockets)
    other = subprocess.run([sys.executable, "-c", "import socket; socket.socket(socket.AF_UNIX)"], capture_output=True)
    assert other.returncode == 1 and b"[Errno 13]" in other.stderr


def test_no_thread_and_no_child_gets_a_socket():
    in_child(threads_and_children)


def call_i386(number):
    """A system call by the numbers of i386: push %rbx; mov %edi, %eax; mov $1, %ebx; xor %ecx, %ecx; xor %edx, %edx; int $0x80; pop %rbx; ret."""
    code = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    code.write(bytes.fromhex("53 89f8 bb01000000 31c9 31d2 cd80 5b c3"))
    return ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(code)))(number)


@pytest.mark.skipif(not X86_64, reason="another architecture")
def test_no_call_of_another_architecture():
    getpid, socketcall, of_socket = 20, 102, 359

    def attack():
        close_network()
        assert [call_i386(number) for number in (getpid, socketcall, of_socket)] == [-errno.EACCES] * 3
    if status_of_child(lambda: sys.exit(call_i386(getpid) <= 0)) == 0:  # else the kernel has no such calls: ENOSYS, or SIGSEGV
        in_child(attack)
