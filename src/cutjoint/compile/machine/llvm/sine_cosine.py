"""Sine and cosine together, as branch-free instructions for one number or for a vector of them.

The processor's vector units have no sine, and calling the C library lane by lane costs more than a whole mechanism.
Method: the argument is reduced to |y| <= pi/4 by subtracting the nearest multiple of pi/2 in three pieces (Cody and
Waite), keeping the rounding error of y; then two polynomials, which interpolate (sin y - y)/y^3 and
(cos y - 1 + y^2/2)/y^4 at the Chebyshev points of the interval.  The error is below one unit in the last place.
Arguments beyond LARGEST give NaN, which the callers treat like a posture that cannot be evaluated.
"""

from __future__ import annotations

from cutjoint.compile.machine.llvm.lanes import Lanes

LARGEST = 1.0e4
"""Largest angle [rad]; the first two pieces of pi/2 times a multiple are exact far beyond it."""

PI_HALF = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""pi/2 in pieces of 33, 33 and 53 bits."""

SINE = (
    -0.16666666666666666,
    0.008333333333330946,
    -0.0001984126983675497,
    2.755731610068303e-06,
    -2.5051131455427946e-08,
    1.591810123027412e-10,
)
COSINE = (
    0.041666666666666664,
    -0.0013888888888887395,
    2.4801587298763433e-05,
    -2.7557317270560326e-07,
    2.0876146024689747e-09,
    -1.1382614868556325e-11,
)
ROUND = 6755399441055744.0
"""1.5 * 2^52: adding it rounds to a whole number, which then stands in the low bits."""
TWO_OVER_PI = 0.6366197723675814


def sine_cosine(a: Lanes, x: str) -> tuple[str, str]:
    """Names of sine and cosine of `x`."""
    shifted = a.add(a.mul(x, a.constant(TWO_OVER_PI)), a.constant(ROUND))
    multiple = a.sub(shifted, a.constant(ROUND))
    quarter = a.out.emit(f"bitcast {a.type} {shifted} to {a.whole}")

    # y + rest = x - multiple * pi/2
    first = a.sub(x, a.mul(multiple, a.constant(PI_HALF[0])))
    second = a.mul(multiple, a.constant(PI_HALF[1]))
    y = a.sub(first, second)
    rest = a.sub(a.sub(a.sub(first, y), second), a.mul(multiple, a.constant(PI_HALF[2])))
    small = a.out.emit(f"fcmp ole {a.type} {a.absolute(x)}, {a.constant(LARGEST)}")
    y = a.choose(small, y, a.constant(float("nan")))

    z = a.mul(y, y)
    # sin(y + rest) = y + (y^3 S(z) + rest (1 - z/2))
    half = a.mul(z, a.constant(0.5))
    below = a.sub(a.constant(1.0), half)
    cubic = a.mul(a.mul(y, z), a.polynomial(SINE, z))
    sine = a.add(y, a.add(cubic, a.mul(rest, below)))
    # cos(y + rest) = (1 - z/2) + ((1 - (1 - z/2) - z/2) + (z^2 C(z) - y rest))
    lost = a.sub(a.sub(a.constant(1.0), below), half)
    quartic = a.mul(a.mul(z, z), a.polynomial(COSINE, z))
    cosine = a.add(below, a.add(lost, a.sub(quartic, a.mul(y, rest))))

    # odd quarters swap the two; the signs follow bits of the quarter
    odd = a.out.emit(f"trunc {a.whole} {quarter} to {a.boolean}")
    s = a.choose(odd, cosine, sine)
    c = a.choose(odd, sine, cosine)
    after = a.out.emit(f"add {a.whole} {quarter}, {a.integer(1)}")
    return _flip(a, s, quarter), _flip(a, c, after)


def _flip(a: Lanes, value: str, quarter: str) -> str:
    """`value` with its sign changed where bit 1 of `quarter` is set."""
    bit = a.out.emit(f"and {a.whole} {quarter}, {a.integer(2)}")
    sign = a.out.emit(f"shl {a.whole} {bit}, {a.integer(62)}")
    bits = a.out.emit(f"bitcast {a.type} {value} to {a.whole}")
    flipped = a.out.emit(f"xor {a.whole} {bits}, {sign}")
    return a.out.emit(f"bitcast {a.whole} {flipped} to {a.type}")
