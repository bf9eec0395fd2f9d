"""Plates: significance by the printed R2, the words' components, and the reference's figures."""

import math

import numpy as np

def f_tail(f, first, second):
    """Probability above f of Fisher's distribution, by the beta integral."""
    x = first * f / (first * f + second)
    # A substitution without the singularities at the ends.
    angle = np.linspace(math.asin(math.sqrt(x)), math.pi / 2, 20001)
    density = np.sin(angle) ** (first - 1) * np.cos(angle) ** (second - 1)
    whole = math.exp(math.lgamma(first / 2) + math.lgamma(second / 2) - math.lgamma((first + second) / 2)) / 2
    return np.sum((density[1:] + density[:-1]) / 2) * (angle[1] - angle[0]) / whole


# Table 2: loadings of eight words on three components, eigenvalues and shares.
LOADINGS = np.array([
    [0.893, -0.065, 0.0141],
    [-0.873, 0.0528, 0.0976],
    [0.853, -0.0617, 0.0413],
    [-0.06, 0.874, -0.0498],
    [-0.0711, 0.824, -0.0597],
    [0.0419, -0.791, 0.106],
    [-0.014, -0.0621, 0.927],
    [-0.0199, -0.127, 0.918],
])
SHARES = [28.7, 26.2, 21.6]


def components(scores):
    """Loadings of the words on the components whose eigenvalue is above 1, and their share."""
    values, vectors = np.linalg.eigh(np.corrcoef(scores.T))
    kept = values > 1
    return varimax(vectors[:, kept] * np.sqrt(values[kept])), values[kept].sum() / len(values)


def varimax(loadings):
    """Turns the components so that each word loads on few of them, as Table 2's do."""
    turn = np.eye(loadings.shape[1])
    for _ in range(100):
        turned = loadings @ turn
        u, _, v = np.linalg.svd(loadings.T @ (turned**3 - turned * np.square(turned).mean(0)))
        turn = u @ v
    return loadings @ turn


def deleted(scores, words):
    """Section 2.2's rule: while the components explain 0.75 or less, the word that loads least on any of them goes."""
    words, gone = list(words), []
    while True:
        loadings, share = components(scores)
        if share > 0.75:
            return words, gone, loadings.shape[1], share
        least = np.argmin(np.abs(loadings).max(axis=1))
        gone.append(words.pop(least))
        scores = np.delete(scores, least, axis=1)


def words(checks):
    """Scores with Table 2's loadings and five words that load little: the rule has to find the eight again."""
    for component, (share, own) in enumerate(zip(SHARES, 100 * np.square(LOADINGS).mean(0)), 1):
        checks.near(f"S3: share of component {component}, from Table 2's loadings, %", share, own, 0.1)
    whole = 100 * np.square(LOADINGS).sum() / len(LOADINGS)
    checks.near("S3: share of three components, from Table 2's loadings, %", 76.6, whole, 0.1)
    checks.near("S3: sum of Table 2's eigenvalues, over 8 words, %", 76.6, 100 * (2.55 + 2.11 + 1.47) / 8, 0.1)
    random, people = np.random.default_rng(4), 4000
    little = np.vstack([LOADINGS, random.uniform(-0.35, 0.35, (5, 3))])
    own = np.sqrt(1 - np.square(little).sum(1))
    scores = random.standard_normal((people, 3)) @ little.T + own * random.standard_normal((people, 13))
    names = ["soft", "hard", "elastic", "rough", "coarse", "smooth", "cold", "cool", "sticky", "fine", "dry", "moist", "warm"]
    kept, gone, count, share = deleted(scores, names)
    shown = f"{len(kept)} words, {count} components, {100 * share:.1f} %; deleted {', '.join(gone)}"
    checks.true("S3: the deletion rule on 13 words", shown, set(names[:8]) <= set(kept) and len(kept) < 10 and count == 3)
    checks.step("plates", "share of three components", "Table 2", "28.7, 26.2, 21.6; 76.6 %", ", ".join(f"{100 * s:.1f}" for s in np.square(LOADINGS).mean(0)) + f"; {whole:.1f} %", "NumPy, from the printed loadings")
    checks.step("plates", "deletion rule, from 13 words", "section 2.2", "8 words, 3 components, 76.6 %", f"{len(kept)} words, {count} components, {100 * share:.0f} %", "NumPy, scores made from Table 2's loadings and five weak words")


def plates(checks):
    count = 8
    for what, r2, variables, most in (
        ("Soft by SA I", 0.562, 1, 0.05),
        ("Rough by FA II and M", 0.817, 2, 0.05),
        ("Soft by Ra", 0.586, 1, 0.05),
        ("Rough by Ra", 0.788, 1, 0.01),
    ):
        freedom = count - variables - 1
        p = f_tail(r2 / variables / ((1 - r2) / freedom), variables, freedom)
        checks.true(f"S3: {what}, R2 = {r2} of {count} plates: p < {most}", f"p = {p:.3g}", p < most)
        checks.step("plates", f"p of *{what.split()[0]}* by {what.split(' by ')[1]}, R2 = {r2}", "section 3.3", f"below {most}", f"{p:.2g}", "NumPy, of 8 plates")
    # With one variable the standardised coefficient is the root of R2, with the coefficient's sign.
    checks.near("S3: standardised coefficient of Soft by SA I", -0.75, -math.sqrt(0.562), 5e-3)
    checks.near("S3: equation 5, Hz", 82.64, 10 / 0.121, 5e-3)
    checks.near("S3: equation 6, V/um", 0.563, 0.313 / (2 * 0.278), 5e-4)
    checks.step("plates", "standardised coefficient of *Soft* by SA I", "Figure 6", "a picture, negative", f"{-math.sqrt(0.562):.2f}", "NumPy: the root of R2")
    words(checks)
