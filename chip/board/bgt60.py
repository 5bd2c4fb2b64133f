"""BGT60TR13C at SPI1: registers, FIFO, frames and the status byte (data sheet V2.4.9, sections in brackets).

Register for register the model of `host-sim/src/modules/bgt60.rs`, byte by byte as the wire has it: a transaction is what is
transferred while PA4 is low.
"""

from model.units import seconds, us

MAIN, ADC0, CHIP_ID, PACR1, PACR2, SFCTL, CCR, PLL1, FSTAT = 0x00, 0x01, 0x02, 0x04, 0x05, 0x06, 0x2C, 0x30, 0x5F
CLOCK_ERROR, BURST_ERROR, UNDERFLOW, OVERFLOW = 1 << 17, 1 << 18, 1 << 19, 1 << 23
CLOCK_ON, FAST_MISO = 1 << 23, 1 << 16
CLOCK_MHZ, FIFO_WORDS = 80, 8192
# SPI clock up to which the chip sends with the edge of mode 0 [table 27], Hz.
FASTEST_HZ = 25e6


class Bgt60:
    """The radar chip; `echo(frame)` gives the samples of a frame, 12-bit codes."""

    def __init__(self, chip, echo):
        self.chip, self.echo = chip, echo
        self.frames_done = 0
        self.glitch = False  # The next burst gets a clock too many.
        self.errors_seen = []
        self.reset()
        self.selected = False
        chip.gpio.watch("PA4", self.on_select)
        chip.spi1.transfer = self.transfer

    def reset(self):
        self.r = [0] * 0x60
        self.r[MAIN] = 3 << 19 | 3 << 17
        self.r[ADC0] = 40 << 14 | 1 << 9 | 1 << 6
        self.r[CHIP_ID] = 0x000303
        self.r[PACR1], self.r[PACR2] = 0x196524, 1 << 18 | 20
        self.r[SFCTL] = 14 << 19 | FAST_MISO
        for address in (0x0B, 0x0F, 0x16, 0x1D, 0x24, 0x2B):
            self.r[address] = 0xB60
        self.errors = self.status = 0
        self.reset_fifo()

    def reset_fifo(self):
        self.fifo = []
        self.errors &= ~(OVERFLOW | UNDERFLOW)
        self.count, self.ends = 0, None

    # Frames.

    def field(self, address, low, bits):
        return self.r[address] >> low & (1 << bits) - 1

    def scaled(self, address, low, multiplier, bits):
        power = self.field(address, multiplier, bits)
        return self.field(address, low, 8) * 8 * 2**power + power + 3

    def duration_us(self):
        """Length of a frame [3.4, 4.12 to 4.16]."""
        until = self.field(CCR + 3, 0, 9) * 8 + self.field(CCR + 3, 9, 5) * 8 + 1
        settle = self.scaled(CCR + 3, 14, 22, 2) + self.scaled(CCR, 14, 22, 2)
        clocks = self.scaled(MAIN, 4, 12, 4) + settle + until + self.field(ADC0, 14, 10) * self.field(PLL1 + 3, 0, 12)
        return clocks / CLOCK_MHZ

    def start_frame(self):
        most = self.r[CCR + 2] & 0xFFF
        if self.r[PACR1] & CLOCK_ON and self.ends is None and (most == 0 or self.count < most):
            self.ends = self.chip.after(us(self.duration_us()), self.end_frame)

    def end_frame(self):
        self.ends = None
        self.count += 1
        self.r[PACR1] &= ~CLOCK_ON
        samples = self.field(PLL1 + 3, 0, 12)
        codes = list(self.echo(self.frames_done))[:samples]
        codes += [2048] * (samples - len(codes))
        self.frames_done += 1
        for first, second in zip(codes[::2], codes[1::2]):
            if len(self.fifo) == FIFO_WORDS:
                self.errors |= OVERFLOW
                return
            self.fifo.append(first << 12 | second)

    def state(self):
        fill = len(self.fifo)
        return self.errors | fill | (fill > self.r[SFCTL] & 0x1FFF) << 21 | (fill == 0) << 20 | (fill == FIFO_WORDS) << 22

    # The wire.

    def on_select(self, level):
        if level and self.selected:
            self.end_transaction()
        self.selected = not level
        self.sent, self.back = bytearray(), None

    def transfer(self, byte):
        if not self.selected:
            return 0xFF
        if self.chip.spi1.hz() > FASTEST_HZ:
            self.chip.complain(f"BGT60: SPI clock {self.chip.spi1.hz() / 1e6:.1f} MHz [table 27]")
        self.sent.append(byte)
        answer = self.answer(len(self.sent) - 1)
        if self.r[SFCTL] & FAST_MISO:
            # Each bit changes before it is sampled: the answer comes a bit early.
            following = self.answer(len(self.sent))
            return answer << 1 & 0xFF | following >> 7
        return answer

    def answer(self, k):
        """Byte `k` of the answer: status, then the register or the burst's words."""
        if k == 0:
            return 0xF0 | bool(self.errors & (OVERFLOW | UNDERFLOW)) << 3 | bool(self.r[SFCTL] & FAST_MISO) << 2 | self.status
        if len(self.sent) < 4:
            # The register's value follows its address at once.
            address = self.sent[0] >> 1
            if address == 0x7F:
                return 0
            return self.read(address) >> 8 * (3 - k) & 0xFF if k < 4 else 0
        if self.sent[0] == 0xFF and k >= 4:
            return self.burst_byte(k - 4)
        return self.read(self.sent[0] >> 1) >> 8 * (3 - k) & 0xFF if k < 4 else 0

    def burst_byte(self, k):
        if k % 3 == 0 and (self.back is None or self.back[0] != k):
            command = int.from_bytes(self.sent[:4], "big")
            start = command >> 17 & 0x7F
            value = self.pop() if start == 0x60 else self.read(start + k // 3)
            self.back = (k, value)
        return self.back[1] >> 8 * (2 - k % 3) & 0xFF

    def pop(self):
        if self.fifo:
            return self.fifo.pop(0)
        self.errors |= UNDERFLOW
        return 0xFF_FFFF

    def read(self, address):
        return self.state() if address == FSTAT else self.r[address] if address < len(self.r) else 0

    def end_transaction(self):
        sent, self.status = self.sent, 0
        clocks = words = False
        if len(sent) < 4:
            clocks = bool(sent)
        elif sent[0] == 0xFF:
            whole, asked = (len(sent) - 4) // 3, sent[2] >> 1 & 0x7F
            words = bool(asked) and asked != whole
            clocks = bool((len(sent) - 4) % 3) or self.glitch
            self.glitch = False
        elif len(sent) > 4:
            clocks = True
        elif sent[0] & 1:
            self.write(sent[0] >> 1, int.from_bytes(sent[1:4], "big"))
        if clocks or words:
            self.errors_seen.append(seconds(self.chip.now()))
            # Reported until they are cleared by a reset [4.24].
            self.status = clocks | words << 1
            self.errors |= clocks * CLOCK_ERROR | words * BURST_ERROR
        self.status = bool(self.errors & CLOCK_ERROR) | bool(self.errors & BURST_ERROR) << 1

    def write(self, address, value):
        if address == MAIN:
            self.r[MAIN] = value & ~0xF
            if value & 2:
                self.reset()
            elif value & 8:
                self.reset_fifo()
            elif value & 4:
                self.count, self.ends = 0, None
            elif value & 1:
                self.start_frame()
        elif address not in (CHIP_ID, 3) and address < 0x5D:
            self.r[address] = value
