"""The story of mapping one session: poses, scene, fixations."""
