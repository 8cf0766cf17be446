"""Look-ups in the registry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import sympy
import sympy as sp

from undertow.equation import registry
from undertow.equation.hidden import HiddenResonator
from undertow.equation.kernel import SLOT
from undertow.equation.notation import plain_symbol
from undertow.equation.structure import SineRestoring, Stiffness
from undertow.equation.term import Share, Term
from undertow.errors import ConfigError, UndertowError
from undertow.quantities import Parameter


def test_every_name_in_the_registry_is_there_once():
    assert len(set(registry.names())) == len(registry.names())


@pytest.mark.parametrize("name", registry.names())
def test_every_name_finds_its_own_term(name):
    assert registry.find(name).name == name


@pytest.mark.parametrize("spring", [Stiffness(), SineRestoring()], ids=["stiffness", "pendulum"])
def test_a_spring_starts_where_it_swings_the_mass_at_the_recorded_rate(spring):
    first = spring.start(mass=4.0, rate=3.0, speed=0.5)
    pull = first * spring.force(np.array([1e-6]), np.zeros(1), np.zeros(1), np.zeros(1))[0] / 1e-6
    assert np.sqrt(pull / 4.0) == pytest.approx(3.0)


def test_inner_parameters_are_passed_on():
    assert registry.find("hidden_resonator", damping_ratio=0.3).inner["damping_ratio"] == 0.3


def test_a_misspelt_name_is_answered_with_the_nearest_one():
    with pytest.raises(ConfigError, match="'quadratic_drug' is not in the registry; did you mean 'quadratic_drag'"):
        registry.find("quadratic_drug")


@pytest.mark.parametrize("word", ["cubic", "Cubic"])
def test_a_word_is_answered_with_every_name_that_holds_it(word):
    with pytest.raises(ConfigError, match=f"'{word}' is not.*did you mean 'cubic_damping' or 'cubic_stiffness'"):
        registry.find(word)


def test_a_name_like_none_is_sent_to_the_list():
    with pytest.raises(ConfigError, match="'xyz' is not in the registry; `undertow terms` lists all"):
        registry.find("xyz")


@pytest.mark.parametrize("name", registry.names())
def test_every_term_says_what_it_is(name):
    term = registry.find(name)
    for text in (term.law, term.latex, term.source, term.left_out, type(term).__doc__):
        assert text
        assert text.strip() == text or text == type(term).__doc__


@pytest.mark.parametrize("name", registry.names())
def test_every_parameter_has_a_unit_a_place_in_the_kernel_and_its_symbol_in_the_law(name):
    term = registry.find(name)
    assert set(term.slots) == {p.name for p in term.parameters}
    for parameter in term.parameters:
        assert parameter.unit
        assert plain_symbol(parameter) in term.law
        assert parameter.symbol in term.latex
        slot = term.slots[parameter.name]
        assert slot in SLOT or f"{slot}1" in SLOT


@pytest.mark.parametrize("name", registry.names())
def test_inner_parameters_lie_inside_their_bounds_by_default(name):
    term = registry.find(name)
    for parameter in term.parameters[1:]:
        assert parameter.lower <= term.inner[parameter.name] <= parameter.upper


def test_the_catalogue_has_the_order_of_the_names():
    assert tuple(term.name for term in registry.catalogue()) == registry.names()


def test_a_law_derived_from_another_is_not_taken_for_it():
    class Own(Stiffness):
        """A law of a user's own."""

        name = "own_spring"

    assert (Own.structural, Own.element, Own().start(4.0, 10.0, 1.0) > 0.0) == ("", "", False)
    assert (Stiffness.structural, Stiffness.element, Stiffness().start(4.0, 10.0, 1.0)) == ("k", "elastic", 400.0)


@dataclass(frozen=True)
class Bow(Term):
    """A law of a user's own that is an expression and nothing else."""

    width_m: float = 0.1
    name: ClassVar[str] = "bow"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("force_N", "N", "F_b"), Parameter("width_m", "m", "b"))

    def share(self, p, q, number):
        """A force that levels off, with friction that it presses."""
        form = sp.tanh(q.x / p["width_m"])
        return Share(smooth=p["force_N"] * form, friction=p["force_N"] * form**2)


def test_a_law_outside_the_registry_has_its_force_from_its_expression():
    x, v, still = np.array([0.05, -0.2]), np.array([1.0, -3.0]), np.zeros(2)
    form = np.tanh(x / 0.2)
    assert Bow(width_m=0.2).force(x, v, still, still) == pytest.approx(form + form**2 * np.sign(v), rel=1e-12)
    assert Bow(width_m=0.4).force(x, v, still, still) != pytest.approx(form + form**2 * np.sign(v), rel=1e-3)


def test_a_law_derived_from_a_row_keeps_its_force():
    class Derived(Stiffness):
        """The same under another name."""

        name = "derived_spring"

    assert Derived().force(np.array([0.2]), *3 * [np.zeros(1)]) == pytest.approx([0.2])


def test_a_law_with_neither_an_expression_nor_a_force_is_told_so():
    with pytest.raises(UndertowError, match="empty_law has neither an expression nor a force; write its `share`"):
        type("Empty", (Term,), {"name": "empty_law", "parameters": ()})().force(*4 * [np.zeros(1)])


def test_a_law_with_states_writes_its_force_along_a_motion():
    said = {"name": "bent_water", "share": HiddenResonator.share, "slots": {}}
    own = type("Bent", (HiddenResonator,), {**said, "force": Term.force})
    with pytest.raises(UndertowError, match="bent_water has an expression with states or a delay; write its `force`"):
        own().force(*4 * [np.zeros(1)])


def test_what_is_missing_bears_the_name_of_a_law_as_symmetric_as_its_own():
    """x|x| had been "a spring stiffer to one side"."""
    for law in registry.catalogue():
        known = registry.row(law.missing_as) if law.missing_as else None
        if known is not None and law.smooth and known.smooth:
            x, v = 0.3, 0.2
            one, other = (_odd(each, x, v) for each in (law, known))
            assert one == other, (law.name, known.name)


def _odd(law, x: float, v: float) -> bool:
    """Whether a law of x and v turns with the motion."""
    numbers = dict.fromkeys((p.name for p in law.parameters), 1.0)
    given = sympy.sympify(law.smooth, locals={name: sympy.Symbol(name) for name in (*numbers, "x", "v")})
    here = given.subs({**numbers, "x": x, "v": v})
    return bool(abs(here + given.subs({**numbers, "x": -x, "v": -v})) < 1e-12)


def test_a_curve_of_the_spring_that_is_odd_is_missing_as_an_odd_one():
    assert registry.row("quadratic_stiffness").missing_as == "cubic_stiffness"
