"""The traversal of readings that another grammar would give."""

from delphin.codecs import eds as native

from grounding.language.backends.embedded import Embedded
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs
from tests.plans import written

PARSER = Parser(Embedded(default_verbs()))


def plan(sentence, text):
    return written(PARSER.parse_reading(sentence, native.decode(text)).instructions)


def error(sentence, text):
    result = PARSER.parse_reading(sentence, native.decode(text))
    assert result.instructions == ()
    return result.error


def test_a_place_that_hangs_on_the_noun_is_a_location_for_placing():
    text = """{e2: _1:pronoun_q<0:31>[BV x3] x3:pron<0:31>{x PERS 2, PT zero}[]
      e2:_place_v_1<0:5>{e SF comm}[ARG1 x3, ARG2 x8] _2:_the_q<6:9>[BV x8]
      x8:_cube_n_1<10:14>{x NUM sg}[] e13:_on_p_loc<15:17>{e SF prop}[ARG1 x8, ARG2 x15]
      _3:_the_q<18:21>[BV x15] x15:_block_n_of<22:27>{x NUM sg}[]}"""
    assert plan("place the cube on the block", text) == "place cube @ on-block"


def test_a_place_that_hangs_on_the_verb_describes_the_target_of_taking():
    text = """{e2: e2:_take_v_1<0:4>{e SF comm}[ARG2 x8] _2:_the_q<5:8>[BV x8]
      x8:_cube_n_1<9:13>{x NUM sg}[] e13:_on_p_state<14:16>{e SF prop}[ARG1 e2, ARG2 x15]
      _3:_the_q<17:20>[BV x15] x15:_block_n_of<21:26>{x NUM sg}[]}"""
    assert plan("take the cube on the block", text) == "pick cube ~ on-block"


def test_a_top_that_is_the_first_conjunct_is_climbed_from():
    text = """{e9: e9:_take_v_1<0:4>{e SF comm}[ARG2 x8] x8:_cup_n_1<9:12>{x NUM sg}[]
      e2:_and_c<13:16>{e SF comm}[ARG1 e9, ARG2 e16]
      e16:_push_v_1<17:21>{e SF comm}[ARG2 x22] x22:pron<22:24>{x PERS 3, NUM sg, PT std}[]}"""
    assert plan("take the cup and push it", text) == "pick cup ; push cup"


def test_a_denial_over_a_conjunction_denies_both():
    text = """{i9: i9:neg<0:5>{i}[ARG1 e9] e9:_take_v_1<6:10>{e SF comm}[ARG2 x8]
      x8:_cup_n_1<15:18>{x NUM sg}[] e2:_and_c<19:22>{e SF comm}[ARG1 e9, ARG2 e16]
      e16:_push_v_1<23:27>{e SF comm}[ARG2 x22] x22:_fork_n_1<32:36>{x NUM sg}[]}"""
    assert "negated" in error("don't take the cup and push the fork", text)


def test_a_compound_with_left_is_a_place():
    text = """{e2: e2:_place_v_1<0:5>{e SF comm}[ARG2 x8] _2:_the_q<6:9>[BV x8]
      e14:compound<10:19>{e}[ARG1 x8, ARG2 x15] _3:udef_q<10:14>[BV x15]
      x15:_ball_n_of<10:14>{x NUM sg}[] x8:_left_n_of<15:19>{x NUM sg}[]
      e22:_of_p<20:22>{e}[ARG1 x8, ARG2 x23] x23:_box_n_of<27:30>{x NUM sg}[]}"""
    assert plan("place the ball left of the box", text) == "place ball @ left-of-box"


def test_between_is_given_back_its_second_landmark():
    text = """{e2: e2:_take_v_1<0:4>{e SF comm}[ARG2 x8] _2:udef_q<5:41>[BV x8]
      x13:_cube_n_1<9:13>{x NUM sg}[] e17:_between_p<14:21>{e}[ARG1 x13, ARG2 x18]
      x18:_cup_n_1<26:29>{x NUM sg}[] x8:_and_c<30:33>{x NUM pl}[ARG1 x13, ARG2 x26]
      x26:_fork_n_1<38:42>{x NUM sg}[]}"""
    sentence = "take the cube between the cup and the fork"
    assert plan(sentence, text) == "pick cube ~ between-cup-and-fork"


def test_a_noun_with_a_particle_is_a_command():
    text = """{e2: e2:unknown<0:15>{e}[ARG x4] _1:udef_q<0:15>[BV x4] x4:_lift_n_1<0:4>{x}[]
      e9:_up_p<5:7>{e}[ARG1 x4, ARG2 x10] _3:_the_q<8:11>[BV x10] x10:_ball_n_of<12:16>{x}[]}"""
    assert plan("lift up the ball", text) == "pick ball"


def test_a_relative_clause_is_told_by_its_words():
    text = """{e2: e2:_put_v_1<0:3>{e SF comm}[ARG2 x8, ARG3 e30] _2:_the_q<4:7>[BV x8]
      x8:_cup_n_1<8:11>{x NUM sg}[] e14:_on_p_loc<20:22>{e}[ARG1 x8, ARG2 x15]
      _3:_the_q<23:26>[BV x15] x15:_tray_n_1<27:31>{x NUM sg}[]
      e30:_in_p_loc<32:34>{e}[ARG1 x8, ARG2 x31] _4:_the_q<35:38>[BV x31]
      x31:_box_n_of<39:42>{x NUM sg}[]}"""
    assert (
        plan("put the cup that is on the tray in the box", text) == "place cup @ in-box ~ on-tray"
    )


def test_a_clause_of_time_orders_what_is_done():
    text = """{e2: e2:_after_x_h<18:23>{e SF comm}[ARG1 e4, ARG2 e20]
      e4:_put_v_1<0:3>{e SF comm}[ARG2 x6, ARG3 e9] x6:pron<4:6>{x PERS 3, NUM sg, PT std}[]
      e9:_on_p_loc<7:9>{e SF prop}[ARG1 x6, ARG2 x11] x11:_tray_n_1<14:18>{x NUM sg}[]
      e20:_take_v_1<28:32>{e SF prop}[ARG1 x21, ARG2 x23] x21:pron<24:27>{x PERS 2, PT std}[]
      x23:_cup_n_1<37:40>{x NUM sg}[]}"""
    assert error("put it on the tray after you take the cup", text).startswith('"it"')
    named = text.replace("x6:pron<4:6>{x PERS 3, NUM sg, PT std}", "x6:_lid_n_1<4:6>{x NUM sg}")
    assert (
        plan("put it on the tray after you take the cup", named) == "pick cup ; place lid @ on-tray"
    )
    before = named.replace("_after_x_h", "_before_x_h")
    assert (
        plan("put it on the tray before you take the cup", before)
        == "place lid @ on-tray ; pick cup"
    )
    condition = named.replace("_after_x_h", "_if_x_then")
    assert "condition" in error("put it on the tray if you take the cup", condition)


def test_a_gerund_behind_after_is_a_clause():
    text = """{e2: e2:_push_v_1<18:22>{e SF comm}[ARG2 x3]
      x3:pron<23:25>{x PERS 3, NUM sg, PT std}[]
      e5:_after_p<0:5>{e}[ARG1 e2, ARG2 x6] _1:udef_q<6:16>[BV x6]
      x6:nominalization<6:16>{x}[ARG1 e7] e7:_take_v_1<6:12>{e SF prop, PROG +}[ARG2 x8]
      _2:_the_q<13:16>[BV x8] x8:_cup_n_1<13:16>{x NUM sg}[]}"""
    assert plan("after taking cups push it", text) == "pick cup ; push cup"


def test_a_circle_is_no_plan_and_does_not_hang():
    text = """{e2: e2:_take_v_1<0:4>{e SF comm}[ARG2 x8] x8:_and_c<5:8>{x}[ARG1 x8, ARG2 x8]}"""
    assert error("take and", text)
    text = "{e2: e2:neg<0:4>{e}[ARG1 e3] e3:neg<5:8>{e}[ARG1 e2]}"
    assert error("not not", text)


def test_a_graph_without_a_top_is_no_plan():
    assert error("x", "{: x8:_cup_n_1<0:1>{x}[]}")
