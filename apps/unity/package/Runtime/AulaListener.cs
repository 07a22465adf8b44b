using UnityEngine;

namespace Aula
{
    /// Beside the AudioListener: the head of the listener, and what it wears.
    [RequireComponent(typeof(AudioListener))]
    public sealed class AulaListener : MonoBehaviour
    {
        /// A SOFA file with responses of a head; empty: MIT KEMAR.
        public string hrtf = "";
        /// A sound file with an impulse response that equalizes headphones; empty: none.
        public string headphones = "";
    }
}
