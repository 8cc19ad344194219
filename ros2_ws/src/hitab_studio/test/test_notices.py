"""A page shows each message once, with the number of repetitions, until closed."""

from hitab_studio.pages.notices import NOTICE_SECONDS, NOTICES_MAX, Notices


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_message_goes_after_its_time_from_when_it_was_last_said():
    clock = Clock()
    messages = Notices(clock)
    messages.say("no", "bad")
    clock.now = NOTICE_SECONDS["bad"] - 1
    messages.say("no", "bad")
    clock.now += NOTICE_SECONDS["bad"] - 1
    assert not messages.drop_old()
    clock.now += 2
    assert messages.drop_old()
    assert messages.shown == []


def test_a_message_can_be_closed_and_old_ones_make_room():
    messages = Notices(Clock())
    for i in range(NOTICES_MAX + 2):
        messages.say(f"message {i}")
    assert [m.text for m in messages.shown] == [f"message {i}" for i in range(2, NOTICES_MAX + 2)]
    messages.close(messages.shown[1].number)
    assert len(messages.shown) == NOTICES_MAX - 1
