"""The model itself: each thing that silicon would not forgive is complained of."""

import pytest
from model.chip import Chip
from model.units import units

FLASH, RCC, IWDG, USART2, GPIOA, TIM5 = (0x4002_3C00, 0x4002_3800, 0x4000_3000, 0x4000_4400, 0x4002_0000, 0x4000_0C00)
ACR, KEYR, SR, CR, OPTCR = (FLASH + k for k in (0, 4, 0xC, 0x10, 0x14))
LOCK = 1 << 31


@pytest.fixture
def chip():
    made = Chip()
    made.off = False
    return made


def put(chip, address, value, size=4):
    base = address & 0xF000_0000
    chip.write(None, address - base, size, value, base)


def get(chip, address):
    base = address & 0xF000_0000
    return chip.read(None, address - base, 4, base)


def later(chip, seconds):
    end = chip.time + units(seconds)
    while (due := chip.events.next_time()) is not None and due <= end:
        chip.time = due
        chip.events.run_until(due)
    chip.time = end


def said(chip, *parts):
    found = any(all(part in text for part in parts) for text in chip.complaints)
    assert found, f"{parts} not in {list(chip.complaints)}"


def unlock(chip):
    put(chip, KEYR, 0x4567_0123)
    put(chip, KEYR, 0xCDEF_89AB)


def test_access_with_the_clock_off(chip):
    put(chip, GPIOA, 0)
    said(chip, "GPIOA", "MODER written with the peripheral's clock off")


def test_reserved_bits(chip):
    put(chip, RCC + 0x40, 1 << 17 | 1 << 16)
    said(chip, "APB1ENR", "reserved bits 0x10000")


def test_places_without_a_register(chip):
    put(chip, RCC + 0x3FC, 1)
    put(chip, 0x4003_0000, 1)
    said(chip, "no register")
    said(chip, "no peripheral is modelled")


def test_the_flash_controller_locks_by_its_reset_value(chip):
    unlock(chip)
    assert not get(chip, CR) & LOCK
    # As `write(|w| w.psize()…)` writes it: the reset value with PSIZE.
    put(chip, CR, LOCK | 2 << 8)
    assert get(chip, CR) & LOCK
    said(chip, "LOCK is set beside other bits")
    put(chip, CR, 2 << 8)
    said(chip, "while locked")


def test_keys_out_of_order_bar_the_controller_until_a_reset(chip):
    put(chip, KEYR, 0xCDEF_89AB)
    said(chip, "out of order")
    unlock(chip)
    assert get(chip, CR) & LOCK
    chip.flash.reset()
    unlock(chip)
    assert not get(chip, CR) & LOCK


def program(chip, address, value, size=4):
    old = chip.memory(address, size)
    chip.flash.programming(address, size, old, value)
    chip.flash.settle()


def test_programming_only_clears_bits_and_by_the_size_that_is_set(chip):
    unlock(chip)
    put(chip, CR, 2 << 8 | 1)
    program(chip, 0x0800_4000, 0x1234_5678)
    later(chip, 0.001)
    program(chip, 0x0800_4000, 0xFFFF_0000)
    assert chip.memory(0x0800_4000, 4) == (0x1234_0000).to_bytes(4, "little")
    assert not chip.complaints
    later(chip, 0.001)
    program(chip, 0x0800_4004, 0x12, size=1)
    said(chip, "write of 1 bytes", "PSIZE 2")
    assert get(chip, SR) & 1 << 6 and chip.memory(0x0800_4004, 1) == b"\xff"


def test_programming_needs_pg_and_the_supply(chip):
    program(chip, 0x0800_4000, 0)
    said(chip, "without PG")
    assert chip.memory(0x0800_4000, 4) == b"\xff" * 4
    chip.volts = 2.5
    unlock(chip)
    put(chip, CR, 2 << 8 | 1)
    program(chip, 0x0800_4000, 0)
    said(chip, "32 bits at a time at 2.50 V")


def test_an_erasure_stalls_the_bus_and_wears_the_sector(chip):
    unlock(chip)
    put(chip, CR, 2 << 8 | 1 << 3 | 2)
    put(chip, CR, 2 << 8 | 1 << 3 | 2 | 1 << 16)
    assert get(chip, SR) & 1 << 16
    assert chip.flash.wear[1] == 1
    assert chip.core.stall - chip.time == units(0.25)
    put(chip, CR, 0)
    said(chip, "during an operation")
    later(chip, 0.3)
    assert not get(chip, SR) & 1 << 16


def test_a_protected_sector_stays(chip):
    chip.flash.options &= ~(1 << 16)
    unlock(chip)
    put(chip, CR, 2 << 8 | 2)
    put(chip, CR, 2 << 8 | 2 | 1 << 16)
    said(chip, "sector 0", "write-protected")
    assert get(chip, SR) & 1 << 4


def test_caches_are_reset_only_while_they_are_off(chip):
    put(chip, ACR, 1 << 10)
    put(chip, ACR, 1 << 10 | 1 << 12)
    said(chip, "data cache reset while it is enabled")


def hse_and_pll(chip, wait_states=5):
    put(chip, RCC, get(chip, RCC) | 1 << 16)
    later(chip, 0.005)
    put(chip, RCC + 4, 1 << 29 | 7 << 24 | 1 << 22 | 168 << 6 | 4)
    put(chip, RCC, get(chip, RCC) | 1 << 24)
    later(chip, 0.001)
    put(chip, ACR, wait_states)
    put(chip, RCC + 8, 0b100 << 13 | 0b101 << 10 | 2)
    later(chip, 0.001)


def test_the_clock_path_to_168_mhz(chip):
    hse_and_pll(chip)
    assert chip.rcc.hclk == 168_000_000 and not chip.complaints


def test_too_few_wait_states(chip):
    hse_and_pll(chip, wait_states=4)
    said(chip, "168 MHz with 4 wait states, needs 5")


def test_a_pll_that_is_not_locked(chip):
    put(chip, RCC + 8, 2)
    said(chip, "not locked")
    put(chip, RCC, get(chip, RCC) | 1 << 24)
    put(chip, RCC + 4, 0x2400_3010 | 1 << 22)
    said(chip, "PLLCFGR written while the PLL is on")


def test_the_watchdog_takes_the_old_reload_value_while_rvu_is_set(chip):
    put(chip, IWDG, 0xCCCC)
    put(chip, IWDG, 0x5555)
    put(chip, IWDG + 4, 6)
    put(chip, IWDG + 8, 249)
    put(chip, IWDG, 0xAAAA)
    assert get(chip, IWDG + 12) == 3
    assert chip.iwdg.windows[-1] > 30
    later(chip, 0.001)
    assert get(chip, IWDG + 12) == 0
    put(chip, IWDG, 0xAAAA)
    assert chip.iwdg.windows[-1] == 2.0
    later(chip, 2.1)
    assert chip.wanted_reset == "watchdog"


def test_the_watchdogs_registers_are_protected(chip):
    put(chip, IWDG + 8, 1)
    said(chip, "without the key")


def usart(chip):
    put(chip, RCC + 0x40, 1 << 17)
    put(chip, RCC + 0x30, 0x0010_0001)
    put(chip, GPIOA, 0xA800_0000 | 0b1010 << 4)
    put(chip, GPIOA + 0x20, 0x7700)
    put(chip, USART2 + 8, 139)
    put(chip, USART2 + 12, 1 << 13 | 1 << 3 | 1 << 2)


def test_a_byte_that_is_not_read_in_time_is_an_overrun(chip):
    usart(chip)
    port = chip.usart["USART2"]
    port.arrived(1, 115_108)
    port.arrived(2, 115_108)
    said(chip, "overrun")
    assert get(chip, USART2) & 1 << 3 and get(chip, USART2 + 4) == 1
    assert not get(chip, USART2) & (1 << 3 | 1 << 5)


def test_another_bit_rate_is_a_framing_error(chip):
    usart(chip)
    chip.usart["USART2"].arrived(1, 120_000)
    said(chip, "what is sent at 120000")


def test_bytes_leave_at_their_time_and_by_their_pin(chip):
    usart(chip)
    sent = []
    port = chip.usart["USART2"]
    port.sink = lambda byte, rate: sent.append((chip.time, byte))
    put(chip, USART2 + 4, 65)
    put(chip, USART2 + 4, 66)
    put(chip, USART2 + 4, 67)
    said(chip, "over one that waits")
    later(chip, 0.001)
    assert [byte for _, byte in sent] == [65, 67]
    put(chip, GPIOA, 0xA800_0000)
    put(chip, USART2 + 4, 68)
    said(chip, "PA2 is not in alternate function 7")


def test_timer_counts_microseconds(chip):
    put(chip, RCC + 0x40, 1 << 3)
    put(chip, TIM5 + 0x28, 15)
    put(chip, TIM5 + 0x14, 1)
    put(chip, TIM5, 1)
    later(chip, 0.123)
    assert get(chip, TIM5 + 0x24) == 123_000


def test_random_memory_at_power_up_differs():
    one, other = Chip(1), Chip(2)
    for each in (one, other):
        each.power_on()
    assert one.memory(0x2000_0000, 64) != other.memory(0x2000_0000, 64)
    assert one.memory(0x1000_0000, 64) != other.memory(0x1000_0000, 64)
