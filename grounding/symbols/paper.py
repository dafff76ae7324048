"""Algorithm 1 of the paper, to the letter.

Features are scaled to [0, 1] over all patches. For every word: a normal for each feature, samples
beyond two standard deviations dropped, refit; the features whose standard deviation is then below
a threshold are the word's invariant ones, with a diagonal covariance. Words with the same
invariant features form a concept group.

The paper leaves open what "beyond two standard deviations" means for several features at once:
here a sample is dropped if any feature is. It gives no thresholds: see `PaperConfig`.

Source:
    Hristov, Penkov, Lascarides and Ramamoorthy 2017, sec. 2.3 and Algorithm 1.
"""

from collections.abc import Sequence

import numpy as np

from grounding.features.registry import PAPER_FEATURES
from grounding.symbols.evidence import Corpus, gather
from grounding.symbols.model import MAX_EXAMPLES, Group, Moments, SymbolModel, Word
from grounding.symbols.records import LabelledPatch, PaperConfig, PatchDecision, SymbolConfig
from grounding.types import FloatArray


def fit_paper(patches: Sequence[LabelledPatch], config: SymbolConfig) -> SymbolModel:
    """Learn words as the paper does; on its own features unless others are configured."""
    corpus = gather(patches, config.features or PAPER_FEATURES)
    empty = not len(corpus.values)
    offset = np.zeros(len(corpus.features)) if empty else corpus.values.min(axis=0)
    span = np.ones(len(corpus.features)) if empty else np.ptp(corpus.values, axis=0)
    unit = np.where(span > 0, span, 1.0)
    scaled = (corpus.values - offset) / unit
    words: dict[str, Word] = {}
    invariant: dict[str, tuple[str, ...]] = {}
    decisions = list(corpus.unusable)
    for name in corpus.words:
        word, decided = _fit_word(name, corpus, scaled, config.paper)
        words[name] = word
        decisions.extend(decided)
        sigma = np.sqrt(np.diag(word.moments.scatter) / max(word.moments.weight, 1.0))
        invariant[name] = tuple(
            feature.name
            for feature, each in zip(corpus.features, sigma, strict=True)
            if each < config.paper.sigma_thresh
        )
    return SymbolModel(
        config=config,
        features=tuple(feature.name for feature in corpus.features),
        offset=offset,
        unit=unit,
        words=words,
        groups=_groups(invariant),
        anything=Moments.of(scaled, np.ones(len(scaled)), effective=float(len(scaled))),
        decisions=tuple(decisions),
    )


def _fit_word(
    name: str, corpus: Corpus, scaled: FloatArray, config: PaperConfig
) -> tuple[Word, list[PatchDecision]]:
    rows = [row for row, s in enumerate(corpus.segment) if name in corpus.said[s]]
    samples = scaled[rows]
    spread = np.maximum(samples.std(axis=0), 1e-12)
    near = (np.abs(samples - samples.mean(axis=0)) <= config.cleaning_sigmas * spread).all(axis=1)
    decisions = [
        PatchDecision(
            patch=corpus.patches[row].name,
            segment=corpus.patches[row].segment,
            symbol=name,
            kept=bool(fine),
            reason="" if fine else "beyond the cleaning threshold",
        )
        for row, fine in zip(rows, near, strict=True)
    ]
    kept = samples[near]
    lost = sum(decision.symbol == name for decision in corpus.unusable)
    word = Word(
        moments=Moments.of(kept, np.ones(len(kept)), effective=float(len(kept))),
        kept=len(kept),
        dropped=len(rows) - len(kept) + lost,
        examples=kept[:: max(1, -(-len(kept) // MAX_EXAMPLES))],
        strays=samples[~near][:MAX_EXAMPLES],
    )
    return word, decisions


def _groups(invariant: dict[str, tuple[str, ...]]) -> tuple[Group, ...]:
    """Return the words with the same invariant features, named by these."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for word, features in invariant.items():
        alike.setdefault(features, []).append(word)
    return tuple(
        Group(
            name="+".join(features) or "none",
            words=tuple(words),
            features=features,
            distances=np.empty(0),
            is_sure=bool(features),
        )
        for features, words in sorted(alike.items())
    )
