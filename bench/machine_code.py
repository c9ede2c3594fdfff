# SPDX-License-Identifier: BSD-3-Clause
"""The machine instructions that a warp issues, from how often each line of PTX was run; for
device_counts.py.

ptxas says from which line of the PTX it made each instruction. It moves, joins and copies code, so
a line's instructions are not issued as often as the line was run. But those of one basic block are
all issued equally often: here as often as the median of what their lines say, a line's runs shared
evenly among ptxas' copies of it. Where the number is known (exchanges between lanes, loads and
stores each are one instruction in PTX and in machine code), the method is checked against it:
`MachineCode.issued` says how far it is off.

Left out is what runs in rare cases only: divisions and roots of numbers next to the limits of a
double, and exchanges of a warp whose lanes have not met.
"""
import collections
import re
import statistics
import struct
import subprocess

BYTES = 16  # of an instruction, from compute capability 7.0
# the lowest 12 bits of an instruction. No document of NVIDIA's lists them; nvdisasm shows them
# beside their names
BRANCH, INDIRECT, CALL, RETURN, EXIT, MEET_OUT_OF_LINE = 0x947, 0x949, 0x944, 0x950, 0x94D, 0x348
# the lowest 9: without the kinds of operands
EXCHANGE, LOADS, STORES, LOCAL_LOAD, LOCAL_STORE = 0x189, {0x180,
                                                           0x181}, {0x185, 0x186}, 0x183, 0x187
ARITHMETIC = {"mul.rn.f64": {0x28}, "add.rn.f64": {0x29}, "sub.rn.f64": {0x29},
              "fma.rn.f64": {0x2B}}
ALWAYS = 7  # the predicate of an instruction that has none


def with_lines(text):
    """The PTX of the kernel `march` alone, where each instruction says its own line instead of the
    source's."""
    out, inside, heading = [], False, True
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith(".visible .entry march("):
            inside, heading = True, False
        if not (inside or heading) or re.match(r"\s*\.(loc|file)\s", line):
            continue
        words = line.strip()
        if inside and words.endswith(";") and not words.startswith("."):
            out.append(f"\t.loc 1 {number} 0")
        out.append(line)
        inside = inside and not line.startswith("}")
    return "\n".join([*out, '\t.file 1 "march.ptx"', ""])


def kind_of(opcode):
    """What PTX's instruction is in machine code, where that is one instruction; as a set of
    codes."""
    if opcode.startswith("shfl."):
        return {EXCHANGE}
    if opcode.startswith("ld."):
        return LOADS | {LOCAL_LOAD}
    if opcode.startswith("st."):
        return STORES | {LOCAL_STORE}
    return ARITHMETIC.get(opcode, set())


class MachineCode:
    """What ptxas makes of a file of tests/ptx/make_ptx.py."""

    def __init__(self, ptx, folder):
        text = ptx.read_text()
        source, self.cubin = folder / f"{ptx.stem}.lines.ptx", folder / f"{ptx.stem}.cubin"
        source.write_text(with_lines(text))
        architecture = re.search(r"^\.target (\w+)", text, re.M)[1]
        done = subprocess.run(["ptxas", f"-arch={architecture}", "-lineinfo", "-v", "-o",
                               self.cubin, source],
                              capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"ptxas refuses {ptx}:\n{done.stdout + done.stderr}")
        said = done.stdout + done.stderr
        self.registers = int(re.search(r"Used (\d+) registers", said)[1])
        self.spilled_bytes = int(re.search(r"(\d+) bytes spill stores", said)[1])
        self.opcodes, self.ptx_block = {}, {}
        block = 0
        for number, line in enumerate(text.splitlines(), 1):
            word = re.match(r"\s+(?:@!?%p\d+\s+)?([a-z][a-z0-9._]*)[\s;]", line)
            if word:
                self.opcodes[number] = word[1]
            block += line.rstrip().endswith(":")
            self.ptx_block[number] = block
            block += bool(word and re.match(r"bra|ret|exit", word[1]))
        self._read_instructions()
        self._find_blocks()
        self._count_copies()

    def _readelf(self, *options):
        done = subprocess.run(["readelf", *options, self.cubin], capture_output=True,
                              text=True, check=True)
        return done.stdout.splitlines()

    def _read_instructions(self):
        for row in self._readelf("-SW"):
            section = re.search(r"\.text\.march +PROGBITS +\w+ (\w+) (\w+)", row)
            if section:
                begin, size = (int(n, 16) for n in section.groups())
        # ptxas puts the routines for rare divisions and roots behind the kernel
        end = min([size,
                   *(int(row.split()[1], 16) for row in self._readelf("-sW")
                     if "$__internal" in row)])
        code = self.cubin.read_bytes()[begin:begin + end]
        self.words = list(struct.iter_unpack("<QQ", code[:len(code) // BYTES * BYTES]))
        rows = []
        for row in self._readelf("--debug-dump=decodedline"):
            place = re.match(r"\S+\s+(\d+|-)\s+(0x[0-9a-f]+|0)\b", row)
            if place:
                rows.append((int(place[2], 16) // BYTES, None if place[1] == "-"
                             else int(place[1])))
        self.line = [None] * len(self.words)
        for (first, line), (last, _) in zip(rows, [*rows[1:], (len(self.words), None)]):
            for at in range(first, min(last, len(self.words))):
                self.line[at] = line

    def _code(self, at):
        return self.words[at][0] & 0xFFF

    def _always(self, at):
        return self.words[at][0] >> 12 & 0xF == ALWAYS

    def _target(self, at):
        """Where a branch goes. Its distance counts in 4 bytes: the lowest 8 bits stand in bits 16
        to 23 of the instruction, the others from bit 34."""
        low, high = self.words[at]
        upper = low >> 34 | (high & 0x3FFFF) << 30
        upper -= (upper >> 47) << 48
        return at + 1 + (upper << 8 | low >> 16 & 0xFF) * 4 // BYTES

    def _find_blocks(self):
        """The basic blocks as ranges of instructions, without those that run in rare cases only."""
        count = len(self.words)
        leaders = {0}
        for at in range(count):
            if self._code(at) == BRANCH:
                leaders.add(self._target(at))
            if self._code(at) in (BRANCH, INDIRECT, CALL, RETURN, EXIT):
                leaders.add(at + 1)
        starts = sorted(at for at in leaders if 0 <= at < count)
        blocks = [range(*ends) for ends in zip(starts, [*starts[1:], count])]
        number = {block[0]: k for k, block in enumerate(blocks)}
        before = collections.defaultdict(list)
        for k, block in enumerate(blocks):
            last = block[-1]
            if self._code(last) == BRANCH and self._target(last) in number:
                before[number[self._target(last)]].append(k)
            leaves = self._code(last) in (BRANCH, INDIRECT, RETURN, EXIT) and self._always(last)
            if not leaves and last + 1 in number:
                before[number[last + 1]].append(k)
        rare = {k for k, block in enumerate(blocks)
                if any(self._code(at) in (CALL, MEET_OUT_OF_LINE) for at in block)}
        grown = True
        while grown:  # and what only they lead to
            more = {k for k, from_ in before.items() if k not in rare
                    and all(other in rare for other in from_)}
            rare |= more
            grown = bool(more)
        self.blocks = [block for k, block in enumerate(blocks) if k not in rare]

    def _count_copies(self):
        self.copies = collections.Counter(
            self.line[at] for block in self.blocks for at in block
            if self._code(at) & 0x1FF in kind_of(self.opcodes.get(self.line[at], "")))
        of_block = collections.defaultdict(list)
        for line, copies in self.copies.items():
            of_block[self.ptx_block[line]].append(copies)
        self.usual_copies = {block: statistics.median(copies) for block, copies in of_block.items()}

    def _runs(self, line, times):
        """How often an instruction of this line is issued, as far as the line says."""
        return times.get(line, 0) / (self.copies.get(line)
                                     or self.usual_copies.get(self.ptx_block.get(line), 1))

    def issued(self, times):
        """The instructions issued where line k of the PTX was run times[k] times; and the error of
        the method: of the numbers of exchanges, loads and stores, the one that is furthest from the
        known, as a share."""
        total, found = 0, collections.Counter()
        for block in self.blocks:
            runs = statistics.median_low(self._runs(self.line[at], times) for at in block)
            total += runs * len(block)
            for at in block:
                found[self._code(at) & 0x1FF] += runs

        def times_of(begin):
            return sum(runs for line, runs in times.items() if self.opcodes[line].startswith(begin)
                       and ".local" not in self.opcodes[line])
        pairs = [(times_of("shfl."), found[EXCHANGE]),
                 (times_of("ld."), sum(found[code] for code in LOADS)),
                 (times_of("st."), sum(found[code] for code in STORES))]
        return total, max((abs(counted / true - 1) for true, counted in pairs if true), default=0)
