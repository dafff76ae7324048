"""Learn what words mean from labelled patches."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grounding.features.registry import Family
from grounding.symbols.concepts import Concept, find_concepts, with_compounds
from grounding.symbols.density import LightSlope
from grounding.symbols.evidence import Corpus, gather, segment_table
from grounding.symbols.model import MAX_EXAMPLES, Group, Moments, SymbolModel, Word
from grounding.symbols.paper import fit_paper
from grounding.symbols.records import LabelledPatch, Mode, PatchDecision, SymbolConfig
from grounding.symbols.robust import Belief, Evidence, known_distances, learn_words
from grounding.symbols.synonyms import join_synonyms
from grounding.types import FloatArray

_KEPT = 0.5


def fit_symbols(patches: Sequence[LabelledPatch], config: SymbolConfig) -> SymbolModel:
    """Learn words, their concept groups and when to say "unknown".

    With too little to learn from, groups are marked unsure; nothing is ever an error but a
    feature's name.

    Args:
        patches: labelled patches; those without an object are counted as dropped.
        config: how to learn.

    Raises:
        ConfigError: if a configured feature is not in the registry.
    """
    if config.mode is Mode.PAPER:
        return fit_paper(patches, config)
    return _fit_robust(gather(patches, config.features), config)


def _fit_robust(corpus: Corpus, config: SymbolConfig) -> SymbolModel:
    unit = np.array([feature.resolution for feature in corpus.features])
    scaled = corpus.values / unit
    rng = np.random.default_rng(config.robust.seed)
    concepts = find_concepts(segment_table(corpus, scaled), rng) if len(scaled) else []
    concepts = with_compounds(concepts, corpus.words)
    anything = Moments.of(scaled, corpus.weights, effective=float(len(corpus.said)))
    words: dict[str, Word] = {}
    groups: list[Group] = []
    decisions = list(corpus.unusable)
    for concept in concepts:
        group, learnt, decided = _fit_group(concept, corpus, scaled, anything, config)
        groups.append(group)
        words.update(learnt)
        decisions.extend(decided)
    model = SymbolModel(
        config=config,
        features=tuple(feature.name for feature in corpus.features),
        offset=np.zeros(len(unit)),
        unit=unit,
        words=words,
        groups=_named(groups),
        anything=anything,
        decisions=tuple(decisions),
    )
    return join_synonyms(model)


def _fit_group(
    concept: Concept, corpus: Corpus, scaled: FloatArray, anything: Moments, config: SymbolConfig
) -> tuple[Group, dict[str, Word], list[PatchDecision]]:
    """Learn one group's words and which patches were kept for them."""
    families = concept.families or tuple(Family)
    features = tuple(f.name for f in corpus.features if f.family in families)
    columns = [k for k, f in enumerate(corpus.features) if f.name in features]
    evidence, rows = _evidence(concept, corpus, scaled, columns, anything)
    belief = learn_words(evidence, config.robust, strangers=bool(concept.families))
    decisions = _decisions(concept, corpus, evidence, belief, rows)
    lost = Counter(d.symbol for d in corpus.unusable)
    kept = Counter(d.symbol for d in decisions if d.kept)
    said = Counter(d.symbol for d in decisions)
    words = {
        word: Word(
            moments=moments,
            kept=kept[word],
            dropped=said[word] - kept[word] + lost[word],
            examples=_shown(evidence, decisions, word, kept=True),
            strays=_shown(evidence, decisions, word, kept=False),
        )
        for word, moments in zip(concept.words, belief.moments, strict=True)
    }
    group = Group(
        name=_group_name(concept),
        words=concept.words,
        features=features,
        distances=known_distances(evidence, belief, config.robust),
        is_sure=bool(concept.families),
        kind_of=concept.kind_of,
    )
    return group, words, decisions


def _shown(
    evidence: Evidence, decisions: list[PatchDecision], word: str, *, kept: bool
) -> FloatArray:
    """Return some patches of a word to show in a picture."""
    rows = [k for k, each in enumerate(decisions) if (each.symbol, each.kept) == (word, kept)]
    return evidence.samples[rows[:: max(1, -(-len(rows) // MAX_EXAMPLES))]]


def _evidence(
    concept: Concept, corpus: Corpus, scaled: FloatArray, columns: list[int], anything: Moments
) -> tuple[Evidence, list[int]]:
    """Return the patches that bear a word of the group, and their rows."""
    labels = [
        next((concept.words.index(w) for w in said if w in concept.words), -1)
        for said in corpus.said
    ]
    bearing = [s for s, label in enumerate(labels) if label >= 0]
    place = {s: index for index, s in enumerate(bearing)}
    rows = [row for row, s in enumerate(corpus.segment) if int(s) in place]
    evidence = Evidence(
        samples=scaled[rows],
        weights=corpus.weights[rows],
        segment=np.array([place[int(corpus.segment[row])] for row in rows], dtype=np.intp),
        label=np.array([labels[s] for s in bearing], dtype=np.intp),
        word_count=len(concept.words),
        columns=columns,
        anything=anything,
        light=LightSlope.of(
            tuple(feature.name for feature in corpus.features),
            np.zeros(len(corpus.features)),
            np.array([feature.resolution for feature in corpus.features]),
        ),
    )
    return evidence, rows


def _decisions(
    concept: Concept, corpus: Corpus, evidence: Evidence, belief: Belief, rows: list[int]
) -> list[PatchDecision]:
    found = []
    for index, row in enumerate(rows):
        right = belief.right[evidence.segment[index]]
        reason = ""
        if right < _KEPT:
            reason = f"the segment's label is right with probability {right:.2g}"
        elif belief.typical[index] < _KEPT:
            reason = "unlike the other patches of its word"
        patch = corpus.patches[row]
        found.append(
            PatchDecision(
                patch=patch.name,
                segment=patch.segment,
                symbol=concept.words[evidence.label[evidence.segment[index]]],
                kept=not reason,
                reason=reason,
            )
        )
    return found


def _group_name(concept: Concept) -> str:
    """Return what a group describes; a word that stands alone is its own group."""
    if concept.kind_of:
        return f"kind of {concept.kind_of}"
    if len(concept.words) == 1:
        return concept.words[0]
    if not concept.families:
        return "unsure"
    names = [str(family) for family in concept.families]
    if Family.SHAPE in concept.families and Family.SIZE in concept.families:
        names.remove(str(Family.SIZE))
    return "+".join(names)


def _named(groups: list[Group]) -> tuple[Group, ...]:
    """Return the groups with names that differ."""
    seen: Counter[str] = Counter()
    named = []
    for group in groups:
        seen[group.name] += 1
        suffix = f"-{seen[group.name]}" if seen[group.name] > 1 else ""
        named.append(replace(group, name=group.name + suffix))
    return tuple(named)
