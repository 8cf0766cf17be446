"""Numbers by which compiled code knows a law, with the parameters and states that each law has.

A law answers with a force on the body (N, positive with x), a mass that moves with the body (kg) and a grip (N), which
is added to the Coulomb force. Numbers are in SI; in a rotation read N m, kg m^2 and rad.
"""

# Algebraic laws of t, x, v: no states.
EVEN = 0  # d, n: -d |v|^n, whatever the direction
LINEAR = 1  # c: -c v
CUBIC = 2  # c3: -c3 v^3
POWER = 3  # d, n: -d |v|^n sign(v)
STIFF = 4  # k1, k2, k3, k5: -(k1 x + k2 x^2 + k3 x^3 + k5 x^5)
SINE = 5  # ks: -ks sin(x)
TONES = 6  # n, then amplitude, frequency, phase n times: sum of A cos(w t + phi)
CURRENT = 7  # q, inertia, n, then U, w, phi n times: drag on v - u and inertia u'
STOP = 8  # gap, stiffness, loss: Hunt-Crossley contact beyond x = gap
MAGNET = 9  # strength, distance: B / (D - x)^2 - B / D^2
LEAK = 10  # mass, time: the body loses mass (1 - exp(-t / time))
HEAT = 11  # stiffness, time: -k' (1 - exp(-t / time)) x
KEULEGAN = 12  # q, share, power, reference: drag whose coefficient follows the last half swing
RAMP = 13  # force, time: a hook that lets go over a time
UNEVEN = 14  # n, then force, wave number, phase n times: grip along the rail
STRIBECK = 15  # force, velocity: grip F exp(-(v / vs)^2)
ONEWAY = 16  # force: grip that differs with the direction
NORMAL = 17  # n: grip n |x|
BEND = 18  # stiffness, span: -K x (1 - (2 x / L)^2), the valley of a bending rail
FADING = 19  # amplitude, frequency, phase, rate: A exp(-g t) cos(w t + phi)
# Laws with hidden states.
RESONATOR = 20  # m, w, zeta, b, g: states s, s'
RELAX = 21  # stiffness, time: state z
CONTACT = 22  # m, w, zeta, gap_plus, gap_minus, stiffness, loss: states s, s'
WAKE = 24  # force, w, epsilon, coupling: states q, q'
SUPPORT = 25  # spring, mass, damping, stiffness: states u, u'
# Friction and hysteresis with states.
DAHL = 30  # stiffness, yield displacement: state r
BOUCWEN = (
    31  # stiffness, yield displacement, n, beta, gamma, d_nu, d_eta, zeta_s, q, p, psi, d_psi, lambda: states z, e
)
IWAN = 32  # n, then stiffness and force n times: states r_i
LUGRE = 33  # sigma0, sigma1, coulomb, static, velocity: state z
RATE_STATE = 34  # mu0, a, b (all times N), V0, Dc: state theta
# Nonlinear water.
CELL = 40  # see cells.py: states beta_i, R_i
# Memory of the body's own velocity.
ECHO = 50  # gain, delay: -G v(t - tau)
KERNEL = 51  # -integral of K(t - s) v(s) ds: state is the integral of x - x_n within a step

# Where the marcher writes what a memory law needs within a step, counted from the law's first number.
MEMORY_ROW, MEMORY_GAIN, MEMORY_DELAY = 0, 1, 2
MEMORY_START, MEMORY_STEP, MEMORY_X, MEMORY_NODES, MEMORY_K0, MEMORY_K1 = 3, 4, 5, 6, 9, 10
MEMORY_SIZE = 11
