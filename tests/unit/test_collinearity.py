"""What the data cannot tell apart is said in words and numbers."""

import numpy as np
import pytest

from undertow.uncertainty.collinearity import collinearity


def covariance_of(columns):
    """Covariance of least-squares coefficients under unit noise."""
    return np.linalg.inv(columns.T @ columns)


def test_independent_terms_leave_nothing_to_say():
    result = collinearity(("a", "b"), np.diag([1.0, 4.0]), np.ones(2))
    assert result.sentences == ()
    assert result.inflation == pytest.approx([1.0, 1.0])


def test_inflation_is_the_variance_beside_that_with_the_others_held():
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((200, 3))
    columns[:, 2] = columns[:, 0] + 0.3 * columns[:, 2]
    covariance = covariance_of(columns)
    alone = 1.0 / np.sum(columns**2, axis=0)
    result = collinearity(("a", "b", "c"), covariance, np.ones(3))
    assert result.inflation == pytest.approx(np.diag(covariance) / alone)
    assert "a and c are partly mixed (correlation -0.9" in result.sentences[0]


def test_a_pair_is_said_with_how_much_worse_each_is_known():
    result = collinearity(("c", "q"), np.array([[1.0, -0.99], [-0.99, 1.0]]), np.ones(2))
    assert "hardly distinguishable (correlation -0.990): alone each is known 7.1 times worse" in result.sentences[0]


def test_three_that_mix_without_any_pair_are_named_as_a_combination():
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((500, 3))
    columns[:, 2] = (columns[:, 0] + columns[:, 1]) / np.sqrt(2.0) + 0.05 * columns[:, 2]
    result = collinearity(("a", "b", "c"), covariance_of(columns), np.ones(3))
    assert any("the least certain combination is" in sentence for sentence in result.sentences)
    # c against a + b: the weakest direction has these signs and shares
    assert np.abs(result.weakest) == pytest.approx([0.5, 0.5, 0.71], abs=0.02)
    assert result.weakest[0] * result.weakest[2] < 0.0


def test_units_of_a_coefficient_do_not_change_what_is_said():
    covariance = np.array([[1.0, 0.95], [0.95, 1.0]])
    factors = np.array([1e-3, 1e4])
    plain = collinearity(("a", "b"), covariance, np.ones(2))
    scaled = collinearity(("a", "b"), covariance * np.outer(factors, factors), 1.0 / factors)
    assert scaled.sentences == plain.sentences
    assert scaled.weakest == pytest.approx(plain.weakest)
