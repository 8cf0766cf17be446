"""Physics that makes the sealed motions: laws, an integrator with exact stick and slip, and the Python face of both.

`codes` names the laws, `algebraic`, `hidden`, `friction` and `cells` hold them as compiled functions, `march`
integrates, `motion` is what the rest of the challenge calls. Nothing here knows of cases, laboratories or verdicts.
"""
