//! Sentences without sense, of common words and of made ones: every sound beside every other one.

use super::super::random::Random;

/// Share of common words.
const COMMON_SHARE: f32 = 0.45;
const COMMON: &str = "the a of and to in is you that it he for was on are as with his they at be this from have or by \
    one had not but what all were when we there can an your which their said if do will each about how up out them \
    then she many some so these would other into has more her two like him see time could no make than first been \
    its who now people my made over did down only way find use may water long little very after words called just \
    where most know";
/// Begins, vowels and ends of made syllables, as they are spelled. Those of one letter come more often.
const BEGINS: &str = "b c d f g h j k l m n p r s t v w y z b d f k l m n p r s t m p b f v sh ch th br bl cr cl dr fl \
    fr gr gl pl pr qu sc sk sl sm sn sp st str sw tr tw wh spr";
const VOWELS: &str = "a e i o u a e i o u ai ay ea ee ie oa oo ou ow oi au aw er ar or ur y";
const ENDS: &str = "b d f g k l m n p r s t m n p x b f ve ch sh th ck ft ld lf lk lm lp lt mp nd ng nk nt pt rb rd rk \
    rm rn rp rt sk sp st ss ll ble ment tion ness ful ing ed er";

/// A sentence of a number of words.
pub(super) fn sentence(random: &mut Random, words: usize) -> String {
    let words: Vec<String> = (0..words).map(|_| word(random)).collect();
    format!("{}{}", words.join(" "), random.one(&[".", ",", "?", "!"]))
}

fn word(random: &mut Random) -> String {
    if random.unit() < COMMON_SHARE {
        return part(random, COMMON).to_owned();
    }
    let syllables = random.within(1, 3);
    let mut word = String::new();
    for _ in 0..syllables {
        if random.unit() < 0.85 {
            word += part(random, BEGINS);
        }
        word += part(random, VOWELS);
    }
    if random.unit() < 0.75 {
        word += part(random, ENDS);
    }
    word
}

fn part<'a>(random: &mut Random, list: &'a str) -> &'a str {
    let parts: Vec<&str> = list.split_whitespace().collect();
    parts[random.within(0, parts.len() - 1)]
}
