"""Which things share their Gaussians, and where these stand."""

from __future__ import annotations

import numpy as np
import pytest
from later import later
from support import evaluate

from scenelang.backends.neural.distillation.terms import compose, initial_theta, zero_offsets
from scenelang.backends.neural.distillation.training import SceneGroups, group_leaves
from scenelang.backends.neural.prompts import Granularity, PromptContext, leaves_of
from scenelang.backends.neural.splats.initial import gaussians_of
from scenelang.grammar.diagnostics import SceneError

torch = later("torch")


def cast(text: str, *entities: str, depth: int | None = None, learned: frozenset[str] = frozenset()) -> SceneGroups:
    return group_leaves(leaves_of(evaluate(text), Granularity(depth, entities), PromptContext(learned)))


ROW = """
(bind "row" (lambda () (union
  (call "sphere" :color [1 0 0])
  (transform (call "sphere" :color [1 0 0]) (@ (translate [3 0 0]) (scale 2)))
  (transform (call "sphere" :color [1 0 0]) (@ (translate [6 0 0]) (rotation [0 0 1] 90 :degrees) (scale [1 2 1])))
  (transform (call "sphere" :color [1 0 0]) (@ (translate [9 0 0]) (scale [1 2 1])))
  (transform (call "sphere" :color [0 0 1]) (translate [12 0 0])))))
""".replace("(rotation [0 0 1] 90 :degrees)", "(rotate 1.5707963 [0 0 1])")


def test_equal_sentences_and_boxes_share_one_theta() -> None:
    found = cast(ROW)
    assert [actor.group for actor in found.instances] == [0, 0, 1, 1, 2]
    for figure in found.groups:
        assert np.linalg.norm(figure.box) == pytest.approx(1.0)


def test_a_pose_takes_the_normalised_box_to_the_thing() -> None:
    for actor in cast(ROW).instances:
        matrix = actor.poses[0, :, :3]
        assert np.allclose(matrix.T @ matrix, np.eye(3) * (matrix[:, 0] @ matrix[:, 0]))  # a turn times one scale
    sizes = [np.abs(a.poses[0, :, :3]) @ cast(ROW).groups[a.group].box for a in cast(ROW).instances]
    assert np.allclose(sizes, [[1, 1, 1], [2, 2, 2], [2, 1, 1], [1, 2, 1], [1, 1, 1]], atol=1e-6)


@pytest.mark.parametrize(
    "pose",
    ["(reflect [0 0 0] [1 0 0])", "(scale [1 3 .2])", "(@ (rotate 1 [1 2 3]) (scale [1 3 .2]) (rotate 1 [3 1 1]))"],
)
def test_the_program_s_own_gaussians_stand_where_they_did(pose: str) -> None:
    """What `local` takes to the figure's frame, the actor's pose takes back to the world, any affine one."""
    text = f'(bind "a" (lambda () (transform (call "cube" :size [1 2 3]) {pose})))'
    if "reflect [0 0 0]" in pose:
        text = text.replace("(reflect [0 0 0] [1 0 0])", "(scale [-1 1 1])")
    found = cast(text)
    (figure,), (actor,) = found.groups, found.instances
    whole = torch.from_numpy(actor.poses[0])
    local = torch.from_numpy(figure.local)
    own = gaussians_of(figure.entity, 200).splats.transformed(local[:, :3], local[:, 3])
    assert float(own.means.abs().sub(torch.from_numpy(figure.box)).max()) < 1e-6
    back = own.transformed(whole[:, :3], whole[:, 3])
    wanted = gaussians_of(evaluate(text).root, 200).splats
    torch.testing.assert_close(back.means, wanted.means)
    torch.testing.assert_close(back.covariances, wanted.covariances)


HATS = """
(bind "people" (lambda () (union (call "hat" :tone "straw") (transform (call "hat" :tone "felt") (translate [4 0 0])))))
(bind "hat" (lambda ((tone "straw")) (union
  (call "cylinder" :radius 1 :p0 [0 0 0] :p1 [0 .1 0])
  (call "cylinder" :radius .5 :p0 [0 .1 0] :p1 [0 1 0]))))
"""


def test_entities_become_leaves_with_their_smallest_boxes() -> None:
    whole = cast(HATS, "hat")
    assert [actor.name for actor in whole.instances] == ["hat", "hat"]
    box = np.abs(whole.instances[0].poses[0, :, :3]) @ whole.groups[0].box
    assert np.allclose(box, [1, 0.5, 1])
    assert np.allclose(whole.instances[0].poses[0, :, 3], [0, 0.5, 0])
    assert len(cast(HATS).instances) == 4
    assert len(cast(HATS, depth=0).instances) == 1
    assert len(cast(HATS, depth=1).instances) == 2


def test_one_thing_may_be_named_by_its_handle() -> None:
    found = cast(HATS, "<z2>")
    assert len(found.instances) == 3
    with pytest.raises(SceneError, match="no entity `<z99>`"):
        cast(HATS, "<z99>")
    with pytest.raises(SceneError, match="no entity `cap`"):
        cast(HATS, "cap")


MOVING = """
(bind "walk" (lambda () (frames (list
  (union (call "sphere" :color [1 0 0]) (call "cube"))
  (union (transform (call "sphere" :color [1 0 0]) (translate [2 0 0])))))))
"""


def test_over_time_a_thing_is_one_figure_with_a_pose_for_each_frame() -> None:
    found = cast(MOVING)
    assert found.frames == 2
    ball, cube = found.instances
    assert ball.visible.tolist() == [True, True]
    assert cube.visible.tolist() == [True, False]
    assert ball.poses[:, 0, 3].tolist() == [0.0, 2.0]
    thetas = [initial_theta(torch.ones(3), 20, torch.Generator().manual_seed(0)).gaussians() for _ in found.groups]
    starts = torch.from_numpy(np.stack([actor.poses for actor in found.instances])).float()
    poses = zero_offsets(2, 2, starts)
    assert len(compose(thetas, found.instances, starts, poses, 0)) == 40
    assert len(compose(thetas, found.instances, starts, poses, 1)) == 20


# --- sentences -----------------------------------------------------------------------------------------------------

BEACH = """
(bind "beach" (lambda () (union
  (call "moai" (embedding <z2> "weathered"))
  (transform (call "moai" (embedding <z3> "mossy")) (translate [3 0 0])))))
(bind "moai" (lambda () (union (call "cube" :color [.9 .9 .9]) (transform (call "sphere") (translate [0 1 0])))))
"""


def sentences(text: str, *entities: str, learned: frozenset[str] = frozenset()) -> list[str]:
    from scenelang.backends.neural.prompts import prompt_text

    (leaves,) = leaves_of(evaluate(text), Granularity(None, entities), PromptContext(learned))
    return [prompt_text(leaf.condition.prompt) for leaf in leaves]


def test_one_entry_speaks_for_the_whole_entity_and_no_other() -> None:
    plain, learned = sentences(BEACH), sentences(BEACH, learned=frozenset({"z2"}))
    assert all("weathered" in text for text in plain[:2])
    assert all("<z2>" in text and "in the style of beach" in text for text in learned[:2])
    assert learned[2:] == plain[2:]
    assert all("mossy" in text for text in plain[2:])
    assert all("<z1>" in text for text in sentences(BEACH, learned=frozenset({"z1"})))


def test_a_leaf_that_is_an_entity_says_its_own_text() -> None:
    assert sentences(BEACH, "moai")[1] == "a mossy moai, in the style of beach, 3D model"


def test_articles() -> None:
    assert sentences('(bind "a" (lambda () (call "cube" :color [.9 .9 .9])))')[0].startswith("an ivory")
