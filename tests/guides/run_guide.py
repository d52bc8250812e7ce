#!/usr/bin/env python3
"""Runs what a guide shows: run_guide.py [--update] --programs DIR GUIDE.md

The blocks of a guide are run in their order in a folder that holds the bundled sample; the guide fails when a command
fails or prints something else. Numbers may differ a little, times altogether. --update writes the true outputs into
the guide.

A block that starts with '$ ' is a transcript: commands, each followed by what it prints; a line '…' in it stands for
any lines. A block of language sh is a script whose output does not matter. Comments right above a block say otherwise:

<!-- not run: WHY -->         leave the block out
<!-- prints: COMMAND -->      the block is what the command prints
<!-- shows: FILE -->          the block is what the file holds
<!-- from FILE -->            the block quotes a file of the repository
<!-- given: COMMAND -->       (anywhere) run this too; readers do not see it
"""
import argparse
import difflib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "rawlogs" / "rooms_agents"
ANY = "…"
LIMIT_S = 300
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Lines whose numbers are times or memory of the machine.
TIMES = re.compile(r"ETA|^time |x real time|cmake|ninja")
PROGRESS = re.compile(r"\s*\d+ %  ")
RELATIVE, ABSOLUTE = 0.2, 0.03


class Failure(Exception):
    pass


class Block:
    """A fenced block, or a given command (language 'given'). Lines are those between the fences."""

    def __init__(self, language, directive, first, last, lines):
        self.language, self.directive = language, directive
        self.first, self.last, self.lines = first, last, lines


def blocks_of(lines):
    blocks, directive, i = [], None, 0
    while i < len(lines):
        comment = re.fullmatch(r"<!-- (not run|prints|shows|from|given):? (.*) -->", lines[i])
        if comment and comment[1] == "given":
            blocks.append(Block("given", None, i, i, [comment[2]]))
        elif comment:
            directive = (comment[1], comment[2])
        elif lines[i].startswith("```"):
            end = next(k for k in range(i + 1, len(lines)) if lines[k].rstrip() == "```")
            blocks.append(Block(lines[i][3:].strip(), directive, i + 1, end, lines[i + 1:end]))
            directive, i = None, end
        elif lines[i].strip():
            if directive:
                raise Failure(f"line {i + 1}: nothing follows <!-- {directive[0]} … -->")
        i += 1
    return blocks


def run(command, folder, programs):
    environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}", LC_ALL="C.UTF-8")
    done = subprocess.run(["bash", "-ec", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LIMIT_S, check=False)
    text = done.stdout.decode().rstrip("\n")
    if done.returncode != 0:
        raise Failure(f"'{command}' ended with status {done.returncode}:\n{text}")
    return text.split("\n") if text else []


def alike(shown, printed):
    """Whether two lines say the same, but for small differences in numbers."""
    a, b = shown.split(), printed.split()
    if len(a) != len(b):
        return bool(TIMES.search(shown)) and NUMBER.sub("0", "".join(a)) == NUMBER.sub("0", "".join(b))
    for x, y in zip(a, b):
        if NUMBER.sub("0", x) != NUMBER.sub("0", y):
            return False
        if TIMES.search(shown):
            continue
        for m, n in zip(NUMBER.findall(x), NUMBER.findall(y)):
            if abs(float(m) - float(n)) > ABSOLUTE + RELATIVE * abs(float(m)):
                return False
    return True


def pieces_of(shown):
    """The stretches of lines between the '…'."""
    pieces = [[]]
    for line in shown:
        if line.strip() == ANY:
            pieces.append([])
        else:
            pieces[-1].append(line)
    return pieces


def places_of(shown, printed, same):
    """Where each piece stands in the output; None when one stands nowhere."""
    pieces, places, at = pieces_of(shown), [], 0
    for k, piece in enumerate(pieces):
        last = k == len(pieces) - 1
        if k == 0:
            candidates = [0]
        elif last:
            candidates = [len(printed) - len(piece)]
        else:
            candidates = range(at, len(printed) - len(piece) + 1)
        place = next((c for c in candidates if c >= at and c + len(piece) <= len(printed) and
                      all(same(s, p) for s, p in zip(piece, printed[c:]))), None)
        if place is None:
            return None
        places.append(place)
        at = place + len(piece)
    return places if at == len(printed) else None


def rewritten(shown, printed):
    """The true output with the '…' where they were, as well as that can be told. Times stay as they are."""
    times = [line for line in shown if TIMES.search(line)]
    printed = [next((t for t in times if alike(t, line)), line) for line in printed]
    pieces = pieces_of(shown)
    if len(pieces) == 1:
        return printed
    first, middle, last = pieces[0], pieces[1:-1], pieces[-1]
    result, at = printed[:len(first)], len(first)
    for piece in middle:
        candidates = range(at, len(printed) - len(last) - len(piece) + 1)
        place = max(candidates, key=lambda c: difflib.SequenceMatcher(
            None, "\n".join(piece), "\n".join(printed[c:c + len(piece)])).ratio(), default=at)
        result += [ANY] + printed[place:place + len(piece)]
        at = place + len(piece)
    return result + [ANY] + printed[len(printed) - len(last):]


class Guide:
    def __init__(self, file, programs, update):
        self.file, self.programs, self.update = file, programs, update
        self.failures, self.commands = [], 0
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="dynemo_guide_"))
        for entry in SAMPLE.iterdir():
            (self.folder / entry.name).symlink_to(entry)
        for name in ("rawlogs", "share", "tests"):
            (self.folder / name).symlink_to(ROOT / name)

    def command(self, text):
        self.commands += 1
        return run(text, self.folder, self.programs)

    def compare(self, what, shown, printed):
        """What the block should hold. Progress appears where a program takes long."""
        if not any(PROGRESS.match(line) for line in shown):
            printed = [line for line in printed if not PROGRESS.match(line)]
        if self.update:
            return rewritten(shown, printed)
        if places_of(shown, printed, alike) is None:
            self.failures.append(f"{what} gives something else than shown (-: shown, +: true):\n" +
                                 "\n".join(list(difflib.unified_diff(shown, printed, lineterm="", n=1))[:40]))
        return shown

    def transcript(self, lines):
        result, i = [], 0
        while i < len(lines):
            command = [lines[i]]
            while command[-1].endswith("\\"):
                i += 1
                command.append(lines[i])
            i += 1
            end = next((k for k in range(i, len(lines)) if lines[k].startswith("$ ")), len(lines))
            text = "\n".join(command)[2:]
            result += command + self.compare(f"'{text}'", lines[i:end], self.command(text))
            i = end
        return result

    def quote(self, name, lines):
        source = (ROOT / name).read_text().split("\n")
        shown = [ANY] + [ANY if line.strip() in (ANY, "...") else line for line in lines] + [ANY]
        if places_of(shown, source, lambda a, b: a == b) is None:
            self.failures.append(f"{name} does not hold, in this order:\n" + "\n".join(lines))

    def true_lines(self, block):
        kind, argument = block.directive or (None, None)
        if kind == "from":
            self.quote(argument, block.lines)
        elif kind == "prints":
            return self.compare(f"'{argument}'", block.lines, self.command(argument))
        elif kind == "shows":
            printed = (self.folder / argument).read_text().rstrip("\n").split("\n")
            return self.compare(argument, block.lines, printed)
        elif kind == "not run":
            pass
        elif block.lines and block.lines[0].startswith("$ "):
            return self.transcript(block.lines)
        elif block.language in ("sh", "given"):
            self.command("\n".join(block.lines))
        return block.lines

    def check(self):
        lines = self.file.read_text().split("\n")
        blocks = blocks_of(lines)
        replacements = []
        for block in blocks:
            try:
                replacements.append((block, self.true_lines(block)))
            except Failure as failure:
                self.failures.append(f"line {block.first + 1}: {failure}")
        if self.update:
            for block, text in reversed(replacements):
                if block.language != "given":
                    lines[block.first:block.last] = text
            self.file.write_text("\n".join(lines))
        shutil.rmtree(self.folder)
        return blocks


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--update", action="store_true", help="write the true outputs into the guide")
    parser.add_argument("--programs", required=True, type=pathlib.Path, help="folder of the programs")
    parser.add_argument("guide", type=pathlib.Path)
    options = parser.parse_args()
    guide = Guide(options.guide, options.programs.resolve(), options.update)
    blocks = guide.check()
    for failure in guide.failures:
        print(f"{options.guide}: {failure}\n")
    print(f"{options.guide.name}: {len(blocks)} blocks, {guide.commands} commands, {len(guide.failures)} failures")
    return 1 if guide.failures else 0


if __name__ == "__main__":
    sys.exit(main())
