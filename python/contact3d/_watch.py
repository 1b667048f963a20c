"""What the program says while it works: progress as a bar, warnings, messages."""

import codecs
import os
import re
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
SPINNER = re.compile(r"^[\u2800-\u28ff ] (?P<what>[a-z]+) +(?P<elapsed>\d+\S*) ?(?P<words>.*)$")
CASES = re.compile(r"^[█▉▊▋▌▍▎▏░▒▓]+ (?P<done>\d+)/(?P<all>\d+) cases,")
STAGE = re.compile(r"^(mesh|assemble|load|solve|post) +(done in|fresh, kept)")
LEVEL = re.compile(r"^(level \d+|mesh) +(?P<words>\S.*)$")
CHATTER = re.compile(r"^(dual|factor|figures?|series) +\S|^(wrote|tables in|case) ")
STAGES = 5
WIDTH = 400


class SceneWarning(UserWarning):
    """Something in a scene that is allowed and probably not meant."""


class Watcher:
    """Takes the lines of standard error as they come."""

    def __init__(self, bar: Any | None):
        self.bar = bar
        self.warnings: list[str] = []
        self.messages: list[str] = []

    def see(self, line: str) -> None:
        """A line, or a picture of a spinner or a bar that the next one replaces."""
        if cases := CASES.match(line):
            self._count(int(cases["done"]), int(cases["all"]))
        elif spinner := SPINNER.match(line):
            self._say(f"{spinner['what']} {spinner['words']}")
        elif stage := STAGE.match(line):
            # A short stage has no spinner.
            self._say(stage[1])
            self._count(None if self.bar is None else self.bar.n + 1, None)
        elif line.startswith("warning: "):
            self.warnings.append(line.removeprefix("warning: "))
        elif level := LEVEL.match(line):
            self._say(line)
            if "hardly be met" in line:
                self.warnings.append(level["words"])
        elif line and not CHATTER.match(line):
            self.messages.append(line)

    def _count(self, done: int | None, of: int | None) -> None:
        if self.bar is not None and done is not None:
            self.bar.total = of or self.bar.total
            self.bar.n = done
            self._draw()

    def _say(self, words: str) -> None:
        if self.bar is not None:
            self.bar.set_postfix_str(words.strip(), refresh=False)
            self._draw()

    def _draw(self) -> None:
        """At once, for `update` skips pictures that follow each other fast, the last one too."""
        if time.time() >= self.bar.start_t + self.bar.delay:
            self.bar.refresh()


class CasesWarning(UserWarning):
    """Cases of a sweep that failed or did not converge."""


def warn(texts: list[str], kind: type[Warning] = SceneWarning) -> None:
    """Hands warnings on to Python, as if the caller of this package had given them."""
    depth, frame = 1, sys._getframe()
    while frame.f_back and frame.f_globals.get("__name__", "").startswith("contact3d."):
        depth, frame = depth + 1, frame.f_back
    for text in texts:
        warnings.warn(text, kind, stacklevel=depth)


def bar(title: str, total: int | None, wanted: bool | None) -> AbstractContextManager[Any]:
    """A bar of tqdm, if it is wanted, or if someone watches and tqdm is there."""
    if wanted is False or (wanted is None and not _is_watched()):
        return nullcontext()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        if wanted:
            raise ImportError("progress needs tqdm: pip install tqdm") from None
        return nullcontext()
    counted = "{desc} {bar} {n_fmt}/{total_fmt} {elapsed}{postfix}" if total else "{desc} {elapsed}{postfix}"
    # What is done within a second flickers only.
    return tqdm(desc=title, total=total, leave=False, bar_format=counted, delay=0.0 if wanted else 1.0)


def _is_watched() -> bool:
    """A terminal, or a kernel of Jupyter."""
    shell = sys.modules.get("IPython")
    kernel = shell and getattr(shell.get_ipython(), "kernel", None)
    return bool(kernel) or bool(sys.stderr and sys.stderr.isatty())


def lines(handle: int) -> Iterator[str]:
    """The lines that come out of a pipe or a terminal, until its other end is closed."""
    decoder, rest = codecs.getincrementaldecoder("utf-8")("replace"), ""
    while chunk := _read(handle):
        *whole, rest = re.split(r"\r\n|\n|\r", rest + decoder.decode(chunk))
        yield from (CONTROL.sub("", line).rstrip() for line in whole)
    yield CONTROL.sub("", rest).rstrip()


def _read(handle: int) -> bytes:
    try:
        return os.read(handle, 1 << 16)
    except OSError:  # The other end of a terminal is closed.
        return b""


def listening_post(shown: bool) -> tuple[int, int]:
    """Two ends, one to read and one for standard error: a terminal for a bar, so that the program draws its progress."""
    if not shown or os.name != "posix":
        return os.pipe()
    import fcntl
    import pty
    import struct
    import termios

    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, WIDTH, 0, 0))
    return ours, theirs


def follow(command: list[str], handle: int, watcher: Watcher, **streams: Any) -> int:
    """Runs a program to its end and sees what it says; an interruption reaches it too, and it is waited for."""
    process = None
    try:
        with _interrupted_later(), os.fdopen(streams.pop("errors"), "wb") as errors:
            process = subprocess.Popen(command, stderr=errors, **streams)
        for line in lines(handle):
            watcher.see(line)
        return process.wait()
    except BaseException as stopped:
        if process is not None:
            _interrupt(process)
            for line in lines(handle):
                watcher.see(line)
        stopped.add_note("\n".join(watcher.messages))
        raise


@contextmanager
def _interrupted_later() -> Iterator[None]:
    """An interruption while a process is started would leave one that nobody knows; it is raised at the end."""
    raised = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(raised):
        yield
        return
    waiting: list[tuple[Any, ...]] = []
    signal.signal(signal.SIGINT, lambda *told: waiting.append(told))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, raised)
    if waiting:
        raised(*waiting[0])


def _interrupt(process: subprocess.Popen[bytes]) -> None:
    """A terminal has told the program too, a notebook has not."""
    for seconds, send in ((0.3, None), (5.0, signal.SIGINT), (5.0, signal.SIGTERM)):
        if send:
            process.send_signal(send)
        try:
            process.wait(timeout=seconds)
            return
        except subprocess.TimeoutExpired:
            continue
    process.kill()
    process.wait()
